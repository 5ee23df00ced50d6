// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstddef>
#include <cstdint>
#include <cstring>
#include <optional>
#include <span>

#include "egomod/core/time.hpp"

namespace egomod {

// Beyond it a time in nanoseconds would overflow: no clock's, but damage.
inline constexpr std::int64_t kMaxUtime_us = 9'000'000'000'000'000;

// An image inside an encoded bot_core.image_t or images_t, found without decoding the message.
struct ImageRecord {
  std::int64_t utime_us = 0;
  std::int32_t width_px = 0;
  std::int32_t height_px = 0;
  std::int32_t row_stride_bytes = 0;
  std::int32_t pixel_format = 0;
  std::int32_t size_bytes = 0;
  std::uint64_t data_offset = 0;  // from the first byte of the message

  [[nodiscard]] Nanoseconds exposure() const { return std::chrono::microseconds(utime_us); }
};

struct StereoRecord {
  std::optional<ImageRecord> left;
  std::optional<ImageRecord> right;
};

// kAmbiguous: more than one image of one camera.
enum class MessageState { kOk, kWrongType, kDamaged, kAmbiguous };

inline constexpr char kAmbiguousImages[] =
    "holds two images of one camera; image_types must be one LEFT and one RIGHT";

// How encoded messages are read: small pieces at given offsets, so that a scan of a log need not
// touch pixels. `fetch` copies bytes, or says that the message ends before them.
class MessageReader {
 public:
  virtual ~MessageReader() = default;
  [[nodiscard]] virtual bool fetch(std::uint64_t offset, std::span<std::uint8_t> to) = 0;
  [[nodiscard]] virtual std::uint64_t size_bytes() const = 0;
};

class MemoryReader final : public MessageReader {
 public:
  explicit MemoryReader(std::span<const std::uint8_t> message) : message_(message) {}
  [[nodiscard]] bool fetch(std::uint64_t offset, std::span<std::uint8_t> to) override {
    if (offset > message_.size() || message_.size() - offset < to.size()) return false;
    std::memcpy(to.data(), message_.data() + offset, to.size());
    return true;
  }
  [[nodiscard]] std::uint64_t size_bytes() const override { return message_.size(); }

 private:
  std::span<const std::uint8_t> message_;
};

// The time of an encoded bot_core.images_t or image_t, also of one that is damaged further on.
[[nodiscard]] std::optional<std::int64_t> find_utime_us(MessageReader& message);
// bot_core.images_t: its LEFT and RIGHT images.
[[nodiscard]] MessageState find_images(MessageReader& message, StereoRecord& found);
// bot_core.image_t.
[[nodiscard]] MessageState find_image(MessageReader& message, ImageRecord& found);

}  // namespace egomod
