// SPDX-License-Identifier: Apache-2.0
#include <chrono>
#include <filesystem>
#include <string>
#include <utility>

#include "capture/folder_contents.hpp"
#include "capture/pair_preparer.hpp"
#include "capture/pairing.hpp"
#include "capture/png_image.hpp"
#include "capture/rig_file.hpp"
#include "capture/sources.hpp"

namespace egomod {
namespace {

namespace fs = std::filesystem;

std::string size_text(ImageSize size) {
  return std::to_string(size.width_px) + "x" + std::to_string(size.height_px);
}

void require_size(const fs::path& file, const Image& image, ImageSize expected) {
  const ImageSize size{image.width_px(), image.height_px()};
  if (size == expected) return;
  throw SourceError(file.string() + ": the image is " + size_text(size) + " pixels, by the " +
                    "calibration or the images before it must be " + size_text(expected));
}

// A calibration without a size takes that of the first image.
void settle_size(FolderContents& contents) {
  StereoCamera& camera = contents.calibration.camera;
  if (camera.width_px != 0) return;
  PngReader png;
  Image left;
  png.read(contents.left.files.front(), left);
  camera.width_px = left.width_px();
  camera.height_px = left.height_px();
}

FolderContents read_folder(const fs::path& folder, bool rig_file_given) {
  if (!fs::is_directory(folder)) {
    throw SourceError("folder:" + folder.string() + ": there is no such folder");
  }
  if (fs::exists(folder / "mav0")) return read_euroc_folder(folder / "mav0", rig_file_given);
  if (fs::exists(folder / "cam0")) return read_euroc_folder(folder, rig_file_given);
  if (fs::exists(folder / "image_0")) return read_kitti_folder(folder, rig_file_given);
  throw SourceError("folder:" + folder.string() + ": holds neither image_0 (KITTI odometry " +
                    "layout) nor mav0/cam0 (EuRoC layout)");
}

class FolderSource final : public FrameSource {
 public:
  FolderSource(FolderContents contents, const CaptureConfig& config)
      : contents_(std::move(contents)),
        partners_(contents_.is_paired_by_index
                      ? std::vector<Partner>{}
                      : pair_by_exposure(contents_.left.exposures, contents_.right.exposures,
                                         skew_limit(config.max_skew_s, contents_.left.exposures,
                                                    contents_.right.exposures))),
        rate_(config.max_rate_hz),
        preparer_(contents_.calibration) {
    Image image;
    read_image(contents_.left.files.front(), image, preparer_.left_size());
    read_image(contents_.right.files.front(), image, preparer_.right_size());
  }

  SourceState next(StereoPair& pair, std::stop_token stop) override {
    if (stop.stop_requested()) return SourceState::kStopped;
    if (!error_.empty()) return SourceState::kFailed;
    if (next_ == size()) return SourceState::kEnd;
    try {
      fill(pair, next_);
    } catch (const SourceError& problem) {
      error_ = problem.what();
      return SourceState::kFailed;
    }
    ++next_;
    return SourceState::kPair;
  }

  [[nodiscard]] bool is_replay() const override { return true; }
  [[nodiscard]] std::uint64_t size() const override { return contents_.left.files.size(); }
  [[nodiscard]] std::string error() const override { return error_; }
  void set_calibration(const Calibration& calibration) override {
    preparer_.set_calibration(calibration);
  }

 private:
  [[nodiscard]] Partner partner(std::size_t left) const {
    return contents_.is_paired_by_index ? Partner{left, true} : partners_[left];
  }

  void fill(StereoPair& pair, std::size_t index) {
    preparer_.begin(pair);
    const auto [right, accepted] = partner(index);
    pair.sequence = index;
    pair.exposure = contents_.left.exposures[index];
    pair.right_exposure = right ? contents_.right.exposures[*right] : pair.exposure;
    const bool is_due = rate_.is_due(pair.exposure);
    if (!accepted) {
      pair.status = PairStatus::kRejected;
    } else if (!is_due) {
      pair.status = PairStatus::kSkipped;
    } else {
      load(pair, contents_.left.files[index], contents_.right.files[*right]);
      rate_.keep(pair.exposure);
    }
    pair.arrival = std::chrono::steady_clock::now().time_since_epoch();
  }

  void load(StereoPair& pair, const fs::path& left, const fs::path& right) {
    read_image(left, preparer_.left_target(pair), preparer_.left_size());
    read_image(right, preparer_.right_target(pair), preparer_.right_size());
    preparer_.finish(pair);
  }

  void read_image(const fs::path& file, Image& image, ImageSize expected) {
    png_.read(file, image);
    require_size(file, image, expected);
  }

  FolderContents contents_;
  std::vector<Partner> partners_;
  RateLimiter rate_;
  PairPreparer preparer_;
  PngReader png_;
  std::size_t next_ = 0;
  std::string error_;
};

}  // namespace

std::unique_ptr<FrameSource> open_folder_source(const std::string& folder,
                                                const CaptureConfig& config,
                                                const std::string& rig_file) {
  try {
    FolderContents contents = read_folder(folder, !rig_file.empty());
    if (!rig_file.empty()) contents.calibration = read_rig_file(rig_file);
    settle_size(contents);
    return std::make_unique<FolderSource>(std::move(contents), config);
  } catch (const fs::filesystem_error& problem) {
    throw SourceError("folder:" + folder + ": " + problem.what());
  }
}

}  // namespace egomod
