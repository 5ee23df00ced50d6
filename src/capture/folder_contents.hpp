// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <filesystem>
#include <string>
#include <vector>

#include "capture/pair_preparer.hpp"
#include "egomod/core/calibration.hpp"
#include "egomod/core/image.hpp"
#include "egomod/core/time.hpp"

namespace egomod {

// What a folder of recorded images holds, whatever its layout.
struct FolderContents {
  struct Camera {
    std::vector<std::filesystem::path> files;  // in order of exposure
    std::vector<Nanoseconds> exposures;        // ascending, one a file
  };
  Camera left;
  Camera right;
  bool is_paired_by_index = true;  // else by exposure
  Calibration calibration;
  std::string calibration_file;  // where it is from, for messages
};

// What `folder:` reads: checks that every image named is there and that the calibration can be
// right; one that tells no size gets that of the first image. `rig_file`, if not empty, stands for
// the folder's own calibration. Throws SourceError.
[[nodiscard]] FolderContents read_folder(const std::string& folder, const std::string& rig_file);

// Throws SourceError that names the file if the image has not the size.
void require_size(const std::filesystem::path& file, const Image& image, ImageSize expected);

// The layouts. Sizes of the calibration may be 0. With `rig_file_given` it is not read.
[[nodiscard]] FolderContents read_kitti_folder(const std::filesystem::path& folder,
                                               bool rig_file_given);
[[nodiscard]] FolderContents read_euroc_folder(const std::filesystem::path& mav0,
                                               bool rig_file_given);

}  // namespace egomod
