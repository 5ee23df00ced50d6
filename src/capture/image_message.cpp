// SPDX-License-Identifier: Apache-2.0
#include "capture/image_message.hpp"

#include <array>
#include <bot_core/image_t.hpp>
#include <bot_core/images_t.hpp>

namespace egomod {
namespace {

constexpr std::int32_t kMaxImages = 64;
constexpr std::int32_t kMaxMetadata = 1024;

// Reads LCM's big-endian fields one after the other; after a field that is not there, `ok` is false
// and every further field 0.
class Fields {
 public:
  explicit Fields(MessageReader& message) : message_(message) {}

  template <typename T>
  T next() {
    std::array<std::uint8_t, sizeof(T)> bytes{};
    ok_ = ok_ && message_.fetch(offset_, bytes);
    if (!ok_) return 0;
    offset_ += sizeof(T);
    std::uint64_t value = 0;
    for (const std::uint8_t byte : bytes) value = value << 8 | byte;
    return static_cast<T>(value);
  }

  void skip(std::int32_t bytes) {
    ok_ = ok_ && bytes >= 0 && static_cast<std::uint64_t>(bytes) <= message_.size_bytes() - offset_;
    if (ok_) offset_ += static_cast<std::uint64_t>(bytes);
  }

  [[nodiscard]] bool ok() const { return ok_; }
  void fail() { ok_ = false; }
  [[nodiscard]] std::uint64_t offset() const { return offset_; }

 private:
  MessageReader& message_;
  std::uint64_t offset_ = 0;
  bool ok_ = true;
};

bool is_time(std::int64_t utime_us) {
  return utime_us >= -kMaxUtime_us && utime_us <= kMaxUtime_us;
}

void skip_metadata(Fields& fields) {
  const auto count = fields.next<std::int32_t>();
  if (count < 0 || count > kMaxMetadata) fields.fail();
  for (std::int32_t i = 0; fields.ok() && i < count; ++i) {
    fields.skip(fields.next<std::int32_t>());  // key, its NUL included
    fields.skip(fields.next<std::int32_t>());  // value
  }
}

ImageRecord next_image(Fields& fields) {
  ImageRecord image;
  image.utime_us = fields.next<std::int64_t>();
  image.width_px = fields.next<std::int32_t>();
  image.height_px = fields.next<std::int32_t>();
  image.row_stride_bytes = fields.next<std::int32_t>();
  image.pixel_format = fields.next<std::int32_t>();
  image.size_bytes = fields.next<std::int32_t>();
  image.data_offset = fields.offset();
  fields.skip(image.size_bytes);
  skip_metadata(fields);
  const bool is_sane = is_time(image.utime_us) && image.width_px > 0 && image.height_px > 0;
  if (!is_sane) fields.fail();
  return image;
}

}  // namespace

std::optional<std::int64_t> find_utime_us(MessageReader& message) {
  Fields fields(message);
  fields.next<std::int64_t>();  // the type
  const auto utime_us = fields.next<std::int64_t>();
  if (!fields.ok() || !is_time(utime_us)) return std::nullopt;
  return utime_us;
}

MessageState find_images(MessageReader& message, StereoRecord& found) {
  Fields fields(message);
  if (fields.next<std::int64_t>() != bot_core::images_t::getHash()) return MessageState::kWrongType;
  fields.next<std::int64_t>();  // utime: each image has its own
  const auto count = fields.next<std::int32_t>();
  if (count <= 0 || count > kMaxImages) return MessageState::kDamaged;
  bool is_ambiguous = false;
  std::array<std::int16_t, kMaxImages> types{};
  for (std::int32_t i = 0; i < count; ++i) {
    types[static_cast<std::size_t>(i)] = fields.next<std::int16_t>();
  }
  for (std::int32_t i = 0; fields.ok() && i < count; ++i) {
    const ImageRecord image = next_image(fields);
    const std::int16_t type = types[static_cast<std::size_t>(i)];
    if (type != bot_core::images_t::LEFT && type != bot_core::images_t::RIGHT) continue;
    auto& camera = type == bot_core::images_t::LEFT ? found.left : found.right;
    is_ambiguous = is_ambiguous || camera.has_value();
    if (fields.ok()) camera = image;
  }
  if (!fields.ok()) return MessageState::kDamaged;
  return is_ambiguous ? MessageState::kAmbiguous : MessageState::kOk;
}

MessageState find_image(MessageReader& message, ImageRecord& found) {
  Fields fields(message);
  if (fields.next<std::int64_t>() != bot_core::image_t::getHash()) return MessageState::kWrongType;
  found = next_image(fields);
  return fields.ok() ? MessageState::kOk : MessageState::kDamaged;
}

}  // namespace egomod
