// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstddef>
#include <cstdint>
#include <string>

namespace egomod {

inline constexpr long kReceiveBufferBytes = 8L << 20;

// The URL with a receive buffer that holds whole images, if it names none; empty stands for
// $LCM_DEFAULT_URL, or LCM's default group.
[[nodiscard]] std::string with_receive_buffer(const std::string& url);

// Of the buffer that the URL asks for what a kernel grants that allows `allowed_bytes`.
[[nodiscard]] long granted_bytes(const std::string& url, long allowed_bytes);
// net.core.rmem_max; 0 if it cannot be read.
[[nodiscard]] long allowed_receive_buffer_bytes();

// Says when images do not fit the receive buffer that was granted. Threads: one caller.
class ReceiveBufferWatch {
 public:
  // 0: it is not known.
  explicit ReceiveBufferWatch(long granted) : granted_bytes_(granted) {}

  struct Traffic {
    std::size_t largest_message_bytes = 0;  // that has arrived
    std::size_t awaited_bytes = 0;          // a raw pair, if one should have come by now
    std::uint64_t lost_images = 0;          // so far
  };
  // Once when messages do not fit, or nothing comes and may be for this reason; then when further
  // images get lost. Empty: nothing to say.
  [[nodiscard]] std::string warning(const Traffic& traffic);

 private:
  // What goes wrong, or seems to; empty if nothing does, or if it was said before.
  [[nodiscard]] std::string trouble(const Traffic& traffic);

  long granted_bytes_;
  bool has_warned_ = false;
  std::uint64_t lost_before_ = 0;
};

}  // namespace egomod
