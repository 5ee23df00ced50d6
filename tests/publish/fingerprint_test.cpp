// SPDX-License-Identifier: Apache-2.0
#include <gtest/gtest.h>

#include <bot_core/images_t.hpp>
#include <initializer_list>
#include <string_view>

namespace {

// LCM's fingerprint, as its type specification defines it: each member's name, type (if primitive)
// and dimensions are hashed; hashes of nested types are added; the sum is rotated by one bit.
class Fingerprint {
 public:
  Fingerprint& member(std::string_view type, std::string_view name,
                      std::string_view array_length = {}) {
    add(name);
    add(type);
    return dimensions(array_length);
  }

  Fingerprint& nested(std::int64_t fingerprint, std::string_view name,
                      std::string_view array_length) {
    add(name);
    nested_ += static_cast<std::uint64_t>(fingerprint);
    return dimensions(array_length);
  }

  [[nodiscard]] std::int64_t value() const {
    const std::uint64_t sum = static_cast<std::uint64_t>(hash_) + nested_;
    return static_cast<std::int64_t>((sum << 1U) | (sum >> 63U));
  }

 private:
  Fingerprint& dimensions(std::string_view variable_length) {
    add(variable_length.empty() ? '\0' : '\1');
    if (!variable_length.empty()) {
      add('\1');  // variable size
      add(variable_length);
    }
    return *this;
  }

  void add(char c) {
    const auto mixed =
        (static_cast<std::uint64_t>(hash_) << 8U) ^ static_cast<std::uint64_t>(hash_ >> 55);
    hash_ = static_cast<std::int64_t>(mixed + static_cast<std::uint64_t>(c));
  }

  void add(std::string_view text) {
    add(static_cast<char>(text.size()));
    for (const char c : text) add(c);
  }

  std::int64_t hash_ = 0x12345678;
  std::uint64_t nested_ = 0;
};

const std::int64_t kMetadata = Fingerprint()
                                   .member("string", "key")
                                   .member("int32_t", "n")
                                   .member("byte", "value", "n")
                                   .value();

const std::int64_t kImage = Fingerprint()
                                .member("int64_t", "utime")
                                .member("int32_t", "width")
                                .member("int32_t", "height")
                                .member("int32_t", "row_stride")
                                .member("int32_t", "pixelformat")
                                .member("int32_t", "size")
                                .member("byte", "data", "size")
                                .member("int32_t", "nmetadata")
                                .nested(kMetadata, "metadata", "nmetadata")
                                .value();

const std::int64_t kImages = Fingerprint()
                                 .member("int64_t", "utime")
                                 .member("int32_t", "n_images")
                                 .member("int16_t", "image_types", "n_images")
                                 .nested(kImage, "images", "n_images")
                                 .value();

TEST(Fingerprint, ImageTypesKeepTheStructureOfBotCore) {
  EXPECT_EQ(bot_core::image_metadata_t::getHash(), kMetadata);
  EXPECT_EQ(bot_core::image_t::getHash(), kImage);
  EXPECT_EQ(bot_core::images_t::getHash(), kImages);
}

}  // namespace
