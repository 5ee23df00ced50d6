// SPDX-License-Identifier: Apache-2.0
#include <algorithm>
#include <chrono>
#include <utility>
#include <vector>

#include "capture/calibration_check.hpp"
#include "capture/channels.hpp"
#include "capture/image_decoder.hpp"
#include "capture/log_file.hpp"
#include "capture/log_index.hpp"
#include "capture/pair_preparer.hpp"
#include "capture/pairing.hpp"
#include "capture/rig_file.hpp"
#include "capture/sources.hpp"

namespace egomod {
namespace {

PairFault fault_of(const LogPair& pair) {
  if (pair.is_damaged()) return PairFault::kDamaged;
  return pair.right ? PairFault::kSkew : PairFault::kNoPartner;
}

class LogSource final : public FrameSource {
 public:
  LogSource(std::unique_ptr<LogFile> log, LogIndex index, const Calibration& calibration,
            const CaptureConfig& config)
      : log_(std::move(log)),
        index_(std::move(index)),
        rate_(config.max_rate_hz),
        preparer_(calibration) {
    reserve_bytes();
    require_a_fitting_image();
  }

  SourceState next(StereoPair& pair, std::stop_token stop) override {
    if (stop.stop_requested()) return SourceState::kStopped;
    if (!error_.empty()) return SourceState::kFailed;
    if (next_ == index_.pairs.size()) {
      error_ = log_->damage();
      return error_.empty() ? SourceState::kEnd : SourceState::kFailed;
    }
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
  [[nodiscard]] std::uint64_t size() const override { return index_.pairs.size(); }
  [[nodiscard]] std::string error() const override { return error_; }
  [[nodiscard]] SourceCounters counters() const override {
    return {.damaged_messages = index_.untimed_messages};
  }
  void set_calibration(const Calibration& calibration) override {
    preparer_.set_calibration(calibration);
  }

 private:
  void reserve_bytes() {
    std::int32_t most = 0;
    for (const LogPair& pair : index_.pairs) {
      most = std::max(most, pair.left.record.size_bytes);
      if (pair.right) most = std::max(most, pair.right->record.size_bytes);
    }
    bytes_.reserve(static_cast<std::size_t>(most));
  }

  // Some images may be damaged; if none fits, it is the calibration that is wrong.
  void require_a_fitting_image() const {
    const ImageSize expected = preparer_.left_size();
    const auto fits = [&](const LogPair& pair) {
      return ImageSize{pair.left.record.width_px, pair.left.record.height_px} == expected;
    };
    const auto whole = std::find_if(index_.pairs.begin(), index_.pairs.end(),
                                    [](const LogPair& pair) { return !pair.left.is_damaged; });
    if (whole == index_.pairs.end() || std::any_of(whole, index_.pairs.end(), fits)) return;
    const ImageRecord& first = whole->left.record;
    throw SourceError(log_->path() + ": its images are " + std::to_string(first.width_px) + "x" +
                      std::to_string(first.height_px) + " pixels, the calibration is for " +
                      std::to_string(expected.width_px) + "x" + std::to_string(expected.height_px) +
                      "; name the right rig file with --rig");
  }

  // A calibration that came later in the log holds from the exposure that it names.
  void follow_calibrations(Nanoseconds exposure) {
    for (; next_calibration_ < index_.calibrations.size(); ++next_calibration_) {
      const TimedCalibration& timed = index_.calibrations[next_calibration_];
      if (timed.holds_from > exposure) return;
      preparer_.set_calibration(timed.calibration);
    }
  }

  void fill(StereoPair& pair, std::size_t i) {
    const LogPair& found = index_.pairs[i];
    const ImageRecord& left = found.left.record;
    follow_calibrations(left.exposure());
    preparer_.begin(pair);
    pair.sequence = i;
    pair.exposure = left.exposure();
    pair.right_exposure = found.right ? found.right->record.exposure() : left.exposure();
    pair.discontinuity = found.discontinuity;
    pair.wheels = found.wheels;
    const bool is_due = rate_.is_due(pair.exposure);
    if (!found.is_accepted || found.is_damaged()) {
      PairPreparer::reject(pair, fault_of(found));
    } else if (!is_due) {
      pair.status = PairStatus::kSkipped;
    } else if (decode(left, preparer_.left_size(), preparer_.left_target(pair)) &&
               decode(found.right->record, preparer_.right_size(), preparer_.right_target(pair))) {
      preparer_.finish(pair);
      rate_.keep(pair.exposure);
    } else {
      PairPreparer::reject(pair, PairFault::kDamaged);
    }
    pair.arrival = std::chrono::steady_clock::now().time_since_epoch();
  }

  bool decode(const ImageRecord& record, ImageSize expected, Image& to) {
    bytes_.resize(static_cast<std::size_t>(record.size_bytes));
    if (!log_->read(record.data_offset, bytes_)) {
      throw SourceError(log_->path() + ": cannot be read any more; was it changed meanwhile?");
    }
    return decoder_.decode(record, bytes_, expected, to);
  }

  std::unique_ptr<LogFile> log_;
  LogIndex index_;
  RateLimiter rate_;
  PairPreparer preparer_;
  ImageDecoder decoder_;
  std::vector<std::uint8_t> bytes_;
  std::size_t next_ = 0;
  std::size_t next_calibration_ = 0;
  std::string error_;
};

// Only what differs from its predecessor; a rig file overrides all.
Calibration take_calibrations(LogIndex& index, const std::string& file,
                              const std::string& rig_file) {
  if (!rig_file.empty()) {
    index.calibrations.clear();
    return read_rig_file(rig_file);
  }
  if (index.calibrations.empty()) {
    throw SourceError(file + ": holds no " + kCalibrationChannel +
                      " message; name a rig file with --rig");
  }
  Calibration first = index.calibrations.front().calibration;
  auto& all = index.calibrations;
  all.erase(std::unique(all.begin(), all.end(),
                        [](const TimedCalibration& a, const TimedCalibration& b) {
                          return a.calibration == b.calibration;
                        }),
            all.end());
  const auto faulty = std::find_if(all.begin(), all.end(), [](const TimedCalibration& timed) {
    return !fault_of(timed.calibration).empty();
  });
  if (faulty != all.end()) {
    throw SourceError(file + ": " + kCalibrationChannel + ": " + fault_of(faulty->calibration) +
                      "; name a rig file with --rig");
  }
  const auto odd = std::find_if(all.begin(), all.end(), [&](const TimedCalibration& timed) {
    return !contradiction(first, timed.calibration).empty();
  });
  if (odd != all.end()) {
    throw SourceError(file + ": its " + kCalibrationChannel + " messages contradict each other (" +
                      contradiction(first, odd->calibration) +
                      "); name the right rig file with --rig");
  }
  all.erase(all.begin());
  return first;
}

}  // namespace

std::unique_ptr<FrameSource> open_log_source(const std::string& file, const CaptureConfig& config,
                                             const std::string& rig_file) {
  auto log = std::make_unique<LogFile>(file);
  LogIndex index = index_log(*log, config);
  if (index.pairs.empty()) {
    if (!log->damage().empty()) throw SourceError(log->damage());
    throw SourceError(file + ": holds no left images on " + ImageChannels(config).text() +
                      "; name other channels with capture.left_channel and " +
                      "capture.right_channel, or record images with publish.images");
  }
  const Calibration calibration = take_calibrations(index, file, rig_file);
  return std::make_unique<LogSource>(std::move(log), std::move(index), calibration, config);
}

}  // namespace egomod
