// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <filesystem>
#include <vector>

#include "egomod/core/image.hpp"

namespace egomod {

// Reads PNG files as 8-bit grey. 16-bit samples are scaled by 255/65535 and rounded, alpha is
// dropped, colour becomes (77 R + 150 G + 29 B + 128) / 256 (the luma of BT.601).
// Its buffers grow to the largest file and stay. Threads: one caller.
class PngReader {
 public:
  // Throws SourceError with file and reason; `image` is then undefined.
  void read(const std::filesystem::path& file, Image& image);

 private:
  std::vector<std::uint8_t> bytes_;
  std::vector<std::uint8_t> pixels_;  // of colour images
  std::vector<std::uint8_t*> rows_;
};

}  // namespace egomod
