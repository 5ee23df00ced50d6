// SPDX-License-Identifier: Apache-2.0
#include <bot_core/images_t.hpp>
#include <egomod/calibration_t.hpp>
#include <filesystem>
#include <optional>

#include "capture/folder_contents.hpp"
#include "capture/pair_preparer.hpp"
#include "capture/pairing.hpp"
#include "capture/png_image.hpp"
#include "commands.hpp"
#include "egomod/app/progress.hpp"
#include "egomod/capture/frame_source.hpp"
#include "egomod/publish/image_encoder.hpp"
#include "egomod/publish/messages.hpp"
#include "egomod/publish/record_writer.hpp"
#include "result_file.hpp"

namespace egomod::log {
namespace {

namespace fs = std::filesystem;

std::int64_t utime_us(Nanoseconds exposure) {
  return std::chrono::duration_cast<std::chrono::microseconds>(exposure).count();
}

std::vector<Partner> partners_of(const FolderContents& contents) {
  const auto& [left, right] = std::pair{contents.left.exposures, contents.right.exposures};
  if (!contents.is_paired_by_index)
    return pair_by_exposure(left, right, skew_limit(0, left, right));
  std::vector<Partner> partners(left.size());
  for (std::size_t i = 0; i < left.size(); ++i) partners[i] = {i, true};
  return partners;
}

// The images of one sequence on their way into a log, as they are on disk.
class Import {
 public:
  Import(FolderContents contents, const std::string& log, std::optional<int> jpeg_quality)
      : contents_(std::move(contents)),
        encoder_(jpeg_quality ? ImageEncoding::kJpeg : ImageEncoding::kRaw,
                 jpeg_quality.value_or(0)),
        preparer_(contents_.calibration),
        file_(log),
        record_(file_.path()) {}

  void run() {
    const std::vector<Partner> partners = partners_of(contents_);
    Progress progress("import", "pairs", partners.size());
    for (std::size_t i = 0; i < partners.size(); ++i) {
      images_.n_images = 0;
      images_.image_types.clear();
      images_.images.resize(2);
      images_.utime = utime_us(contents_.left.exposures[i]);
      add(contents_.left, i, bot_core::images_t::LEFT, preparer_.left_size());
      if (partners[i].accepted) {
        add(contents_.right, *partners[i].nearest, bot_core::images_t::RIGHT,
            preparer_.right_size());
      }
      if (i == 0) write_calibration();
      record_.write({images_channel_, images_.utime, encode_message(images_, buffer_)});
      progress.update(i + 1);
    }
    record_.flush();
    file_.keep();
    progress.finish(partners.size());
  }

 private:
  void add(const FolderContents::Camera& camera, std::size_t index, std::int16_t type,
           ImageSize size) {
    const fs::path& file = camera.files[index];
    png_.read(file, image_);
    require_size(file, image_, size);
    const auto slot = static_cast<std::size_t>(images_.n_images++);
    encoder_.encode(image_.view(), utime_us(camera.exposures[index]), images_.images[slot]);
    images_.image_types.push_back(type);
  }

  void write_calibration() {
    calibration_t message{};
    fill_message(contents_.calibration, contents_.calibration.images_are_raw, message);
    message.utime = images_.utime;
    std::vector<std::uint8_t> buffer;
    record_.write({calibration_channel_, message.utime, encode_message(message, buffer)});
  }

  const std::string calibration_channel_ = "EGOMOD_CALIBRATION";
  const std::string images_channel_ = "EGOMOD_IMAGES";
  FolderContents contents_;
  ImageEncoder encoder_;
  PairPreparer preparer_;  // knows the sizes, and refuses what the daemon would
  ResultFile file_;
  RecordWriter record_;
  PngReader png_;
  Image image_;
  bot_core::images_t images_{};
  std::vector<std::uint8_t> buffer_;
};

}  // namespace

void import_sequence(const std::string& folder, const std::string& log,
                     std::optional<int> jpeg_quality) {
  Import(read_folder(folder, ""), log, jpeg_quality).run();
}

}  // namespace egomod::log
