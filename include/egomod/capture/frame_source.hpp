// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <memory>
#include <stdexcept>
#include <stop_token>
#include <string>
#include <vector>

#include "egomod/bus/bus_address.hpp"
#include "egomod/capture/capture_config.hpp"
#include "egomod/core/stereo_pair.hpp"

namespace egomod {

// A source that cannot be opened: names file, line or device and the remedy.
class SourceError : public std::runtime_error {
 public:
  using std::runtime_error::runtime_error;
};

enum class SourceState {
  kPair,     // a pair was filled in
  kEnd,      // the replay is over
  kStopped,  // the stop token asked
  kFailed,   // the rest cannot be read: `FrameSource::error()` says why; what came before is whole
};

// What a source could not hand out.
struct SourceCounters {
  std::uint64_t lost_images = 0;       // never arrived: gaps in the exposures of the left camera
  std::uint64_t dropped_images = 0;    // arrived too late, or nobody took them in time
  std::uint64_t damaged_messages = 0;  // of a wrong type, or not whole
};

// Where stereo pairs come from: a folder, a log, the bus, cameras.
// Threads: one caller; `next` blocks until a pair, the end or a stop request.
class FrameSource {
 public:
  FrameSource() = default;
  FrameSource(const FrameSource&) = delete;
  FrameSource& operator=(const FrameSource&) = delete;
  virtual ~FrameSource() = default;

  // Fills `pair` in place: images rectified, in order of exposure, sequence counted by the source.
  [[nodiscard]] virtual SourceState next(StereoPair& pair, std::stop_token stop) = 0;
  [[nodiscard]] virtual bool is_replay() const = 0;
  // `next` sleeps until a pair arrives and notes when: such a source keeps its own pace, and its
  // sleep is no work. A replay from a disk hands a pair out whenever it is asked.
  [[nodiscard]] virtual bool waits_for_arrival() const { return !is_replay(); }
  // Pairs in a replay, 0 if unknown: for progress.
  [[nodiscard]] virtual std::uint64_t size() const { return 0; }
  [[nodiscard]] virtual std::string error() const { return {}; }
  // What the operator should know now: what the source waits for, and the remedy. Threads: any.
  [[nodiscard]] virtual std::string notice() const { return {}; }
  // What the operator should know once. Threads: any.
  [[nodiscard]] virtual std::vector<std::string> take_warnings() { return {}; }
  // Threads: any.
  [[nodiscard]] virtual SourceCounters counters() const { return {}; }
  // Takes effect between two pairs (a reload or EGOMOD_CALIBRATION_SET). Throws SourceError, and
  // keeps the old one, if it cannot be right or is for other image sizes. Threads: any.
  virtual void set_calibration(const Calibration& calibration) = 0;
};

// That a spec names a source of this build, and that a rig file can be used: what can be known
// before anything is opened. Throw SourceError.
void check_source(const std::string& spec);
void check_rig(const std::string& rig_file);

// `spec` is the SPEC of --source: folder:DIR, log:FILE, lcm, sim[:WORLD], ... Throws SourceError.
// `rig_file` (may be empty) overrides the calibration that the source brings along. `realtime`: a
// source that could go at any pace keeps that of the wall clock.
[[nodiscard]] std::unique_ptr<FrameSource> open_source(const std::string& spec,
                                                       const CaptureConfig& config,
                                                       const std::string& rig_file,
                                                       const BusAddress& lcm_url,
                                                       bool realtime = false);

}  // namespace egomod
