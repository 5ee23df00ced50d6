// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <optional>
#include <string>

namespace egomod::log {

// Each throws an exception that names what is wrong; a log that is damaged, after what is whole has
// been used.

// Writes the images of a sequence, as they are, and its calibration into a log; JPEG if a quality
// is given.
void import_sequence(const std::string& folder, const std::string& log,
                     std::optional<int> jpeg_quality);

// poses.txt, times.txt, objects.csv and, if the log has timing, timing.csv.
void export_log(const std::string& log, const std::string& folder);

// Prints what the log holds.
void print_info(const std::string& log);

// A PNG for each left image, with tracks and objects. `images`: folder of the sequence; empty: the
// images are in the log.
void draw_log(const std::string& log, const std::string& folder, const std::string& images);

}  // namespace egomod::log
