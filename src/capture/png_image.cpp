// SPDX-License-Identifier: Apache-2.0
#include "capture/png_image.hpp"

#include <png.h>

#include <array>
#include <cerrno>
#include <csetjmp>
#include <cstdio>
#include <cstring>
#include <memory>
#include <new>

#include "capture/grey.hpp"
#include "egomod/capture/frame_source.hpp"

namespace egomod {
namespace {

constexpr int kMaxSidePx = 16384;
constexpr long kMaxFileBytes = 1L << 30;

// All that must survive libpng's longjmp lives here, outside of the frames that it jumps over.
struct Decoder {
  const std::uint8_t* next = nullptr;
  std::size_t left_bytes = 0;
  png_structp png = nullptr;
  png_infop info = nullptr;
  std::array<char, 128> message{};

  Decoder() = default;
  Decoder(const Decoder&) = delete;
  Decoder& operator=(const Decoder&) = delete;
  ~Decoder() { png_destroy_read_struct(&png, &info, nullptr); }
};

[[noreturn]] void on_error(png_structp png, png_const_charp message) {
  auto* decoder = static_cast<Decoder*>(png_get_error_ptr(png));
  std::snprintf(decoder->message.data(), decoder->message.size(), "%s", message);
  png_longjmp(png, 1);
}

void on_warning(png_structp, png_const_charp) {}

void on_read(png_structp png, png_bytep to, png_size_t bytes) {
  auto* decoder = static_cast<Decoder*>(png_get_io_ptr(png));
  if (bytes > decoder->left_bytes) png_error(png, "the file ends too early");
  std::memcpy(to, decoder->next, bytes);
  decoder->next += bytes;
  decoder->left_bytes -= bytes;
}

void start(Decoder& decoder) {
  decoder.png = png_create_read_struct(PNG_LIBPNG_VER_STRING, &decoder, on_error, on_warning);
  if (decoder.png == nullptr) throw std::bad_alloc();
  decoder.info = png_create_info_struct(decoder.png);
  if (decoder.info == nullptr) throw std::bad_alloc();
  png_set_read_fn(decoder.png, &decoder, on_read);
}

// False: `message` says why. Jumped out of by libpng: holds nothing that needs a destructor.
bool read_header(Decoder& decoder) {
  if (setjmp(png_jmpbuf(decoder.png)) != 0) return false;
  png_set_user_limits(decoder.png, kMaxSidePx, kMaxSidePx);
  png_read_info(decoder.png, decoder.info);
  png_set_expand(decoder.png);
  png_set_scale_16(decoder.png);
  png_set_strip_alpha(decoder.png);
  png_set_interlace_handling(decoder.png);
  png_read_update_info(decoder.png, decoder.info);
  return true;
}

bool read_rows(Decoder& decoder, png_bytepp rows) {
  if (setjmp(png_jmpbuf(decoder.png)) != 0) return false;
  png_read_image(decoder.png, rows);
  png_read_end(decoder.png, nullptr);
  return true;
}

void to_grey(const std::uint8_t* rgb, int width_px, std::uint8_t* grey) {
  for (int u = 0; u < width_px; ++u) grey[u] = luma(rgb[3 * u], rgb[3 * u + 1], rgb[3 * u + 2]);
}

struct CloseFile {
  void operator()(std::FILE* file) const { std::fclose(file); }
};

void read_bytes(const std::filesystem::path& path, std::vector<std::uint8_t>& bytes) {
  const std::unique_ptr<std::FILE, CloseFile> file(std::fopen(path.c_str(), "rb"));
  if (!file) throw SourceError(path.string() + ": cannot be opened: " + std::strerror(errno));
  std::fseek(file.get(), 0, SEEK_END);
  const long size = std::ftell(file.get());
  std::rewind(file.get());
  if (size < 0 || size > kMaxFileBytes)
    throw SourceError(path.string() + ": is not a PNG file; restore the image");
  bytes.resize(static_cast<std::size_t>(size));
  if (std::fread(bytes.data(), 1, bytes.size(), file.get()) != bytes.size()) {
    throw SourceError(path.string() + ": cannot be read whole");
  }
}

[[noreturn]] void fail(const std::filesystem::path& file, const Decoder& decoder) {
  throw SourceError(file.string() + ": unreadable PNG: " + decoder.message.data() +
                    "; restore the image");
}

}  // namespace

void PngReader::read(const std::filesystem::path& file, Image& image) {
  read_bytes(file, bytes_);
  Decoder decoder;
  decoder.next = bytes_.data();
  decoder.left_bytes = bytes_.size();
  start(decoder);
  if (!read_header(decoder)) fail(file, decoder);

  const auto width_px = static_cast<int>(png_get_image_width(decoder.png, decoder.info));
  const auto height_px = static_cast<int>(png_get_image_height(decoder.png, decoder.info));
  const int channels = png_get_channels(decoder.png, decoder.info);
  const std::size_t row_bytes = png_get_rowbytes(decoder.png, decoder.info);
  image.resize(width_px, height_px);
  if (channels != 1) pixels_.resize(row_bytes * static_cast<std::size_t>(height_px));
  rows_.resize(static_cast<std::size_t>(height_px));
  for (int v = 0; v < height_px; ++v) {
    const auto row = static_cast<std::size_t>(v);
    rows_[row] = channels == 1 ? image.row(v) : pixels_.data() + row * row_bytes;
  }
  if (!read_rows(decoder, rows_.data())) fail(file, decoder);
  for (int v = 0; channels == 3 && v < height_px; ++v) {
    to_grey(rows_[static_cast<std::size_t>(v)], width_px, image.row(v));
  }
}

}  // namespace egomod
