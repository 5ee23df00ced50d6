// SPDX-License-Identifier: Apache-2.0
#include <chrono>
#include <filesystem>
#include <string>
#include <utility>

#include "capture/folder_contents.hpp"
#include "capture/pair_preparer.hpp"
#include "capture/pairing.hpp"
#include "capture/png_image.hpp"
#include "capture/sources.hpp"

namespace egomod {
namespace {

namespace fs = std::filesystem;

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
      PairPreparer::reject(pair, right ? PairFault::kSkew : PairFault::kNoPartner);
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
  return std::make_unique<FolderSource>(read_folder(folder, rig_file), config);
}

}  // namespace egomod
