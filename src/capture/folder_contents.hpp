// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <filesystem>
#include <vector>

#include "egomod/core/calibration.hpp"
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
  Calibration calibration;         // sizes may be 0: those of the images
};

// Both check that every image named is there. Throw SourceError. With `rig_file_given` the folder's
// calibration is not read.
[[nodiscard]] FolderContents read_kitti_folder(const std::filesystem::path& folder,
                                               bool rig_file_given);
[[nodiscard]] FolderContents read_euroc_folder(const std::filesystem::path& mav0,
                                               bool rig_file_given);

}  // namespace egomod
