// SPDX-License-Identifier: Apache-2.0
#include "capture/folder_contents.hpp"

#include "capture/calibration_check.hpp"
#include "capture/png_image.hpp"
#include "capture/rig_file.hpp"
#include "egomod/capture/frame_source.hpp"

namespace egomod {
namespace {

namespace fs = std::filesystem;

std::string size_text(ImageSize size) {
  return std::to_string(size.width_px) + "x" + std::to_string(size.height_px);
}

FolderContents read_layout(const fs::path& folder, bool rig_file_given) {
  if (!fs::is_directory(folder)) {
    throw SourceError("folder:" + folder.string() + ": there is no such folder");
  }
  if (fs::exists(folder / "mav0")) return read_euroc_folder(folder / "mav0", rig_file_given);
  if (fs::exists(folder / "cam0")) return read_euroc_folder(folder, rig_file_given);
  if (fs::exists(folder / "image_0")) return read_kitti_folder(folder, rig_file_given);
  throw SourceError("folder:" + folder.string() + ": holds neither image_0 (KITTI odometry " +
                    "layout) nor mav0/cam0 (EuRoC layout)");
}

void settle_size(FolderContents& contents) {
  StereoCamera& camera = contents.calibration.camera;
  if (camera.width_px != 0) return;
  PngReader png;
  Image left;
  png.read(contents.left.files.front(), left);
  camera.width_px = left.width_px();
  camera.height_px = left.height_px();
}

}  // namespace

FolderContents read_folder(const std::string& folder, const std::string& rig_file) {
  try {
    FolderContents contents = read_layout(folder, !rig_file.empty());
    if (!rig_file.empty()) {
      contents.calibration = read_rig_file(rig_file);
      contents.calibration_file = rig_file;
    }
    settle_size(contents);
    if (const std::string fault = fault_of(contents.calibration); !fault.empty()) {
      throw SourceError(contents.calibration_file + ": " + fault +
                        "; correct it, or name a rig file with --rig");
    }
    return contents;
  } catch (const fs::filesystem_error& problem) {
    throw SourceError("folder:" + folder + ": " + problem.what());
  }
}

void require_size(const fs::path& file, const Image& image, ImageSize expected) {
  const ImageSize size{image.width_px(), image.height_px()};
  if (size == expected) return;
  throw SourceError(file.string() + ": the image is " + size_text(size) + " pixels, by the " +
                    "calibration or the images before it must be " + size_text(expected));
}

}  // namespace egomod
