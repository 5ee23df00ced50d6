// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <span>
#include <stdexcept>
#include <string>
#include <vector>

namespace egomod {

// A message encoded once, for the bus and for the record.
struct EncodedMessage {
  const std::string& channel;
  std::int64_t utime_us = 0;
  std::span<const std::uint8_t> bytes;
};

// Encodes an LCM type into `buffer`, which only grows. Throws std::length_error when the type and
// its encoding disagree, which a count that differs from its array's length causes.
template <typename Message>
[[nodiscard]] std::span<const std::uint8_t> encode_message(const Message& message,
                                                           std::vector<std::uint8_t>& buffer) {
  const int size = message.getEncodedSize();
  if (buffer.size() < static_cast<std::size_t>(size)) buffer.resize(static_cast<std::size_t>(size));
  if (message.encode(buffer.data(), 0, size) != size) {
    throw std::length_error(std::string("cannot encode ") + Message::getTypeName());
  }
  return {buffer.data(), static_cast<std::size_t>(size)};
}

}  // namespace egomod
