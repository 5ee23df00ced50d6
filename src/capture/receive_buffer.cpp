// SPDX-License-Identifier: Apache-2.0
#include "capture/receive_buffer.hpp"

#include <algorithm>
#include <charconv>
#include <cstdlib>
#include <fstream>
#include <string_view>
#include <utility>

namespace egomod {
namespace {

constexpr const char* kDefaultUrl = "udpm://239.255.76.67:7667?ttl=0";
constexpr std::string_view kParameter = "recv_buf_size=";

}  // namespace

std::string with_receive_buffer(const std::string& given) {
  std::string url = given;
  if (const char* preset = std::getenv("LCM_DEFAULT_URL"); url.empty() && preset != nullptr) {
    url = preset;
  }
  if (url.empty()) url = kDefaultUrl;
  const bool is_set = url.find(kParameter) != std::string::npos;
  if (!url.starts_with("udpm://") || is_set) return url;
  const char join = url.find('?') == std::string::npos ? '?' : '&';
  return url + join + std::string(kParameter) + std::to_string(kReceiveBufferBytes);
}

long granted_bytes(const std::string& url, long allowed_bytes) {
  const std::size_t at = url.find(kParameter);
  if (at == std::string::npos || allowed_bytes <= 0) return 0;
  long wanted_bytes = 0;
  std::from_chars(url.data() + at + kParameter.size(), url.data() + url.size(), wanted_bytes);
  return std::min(wanted_bytes, allowed_bytes);
}

long allowed_receive_buffer_bytes() {
  long allowed_bytes = 0;
  std::ifstream("/proc/sys/net/core/rmem_max") >> allowed_bytes;
  return allowed_bytes;
}

std::string ReceiveBufferWatch::trouble(const Traffic& traffic) {
  if (traffic.lost_images > std::exchange(lost_before_, traffic.lost_images)) {
    return std::to_string(traffic.lost_images) + " images got lost so far";
  }
  const auto is_too_large = [&](std::size_t bytes) {
    return bytes > static_cast<std::size_t>(granted_bytes_);
  };
  if (!has_warned_ && is_too_large(traffic.largest_message_bytes)) {
    return "messages of " + std::to_string(traffic.largest_message_bytes) +
           " bytes are on the bus, and some will get lost";
  }
  const bool waits = traffic.largest_message_bytes == 0 && is_too_large(traffic.awaited_bytes);
  return !has_warned_ && waits ? "no images arrive" : "";
}

std::string ReceiveBufferWatch::warning(const Traffic& traffic) {
  if (granted_bytes_ <= 0 || granted_bytes_ >= kReceiveBufferBytes) return {};
  const std::string what = trouble(traffic);
  if (what.empty()) return {};
  has_warned_ = true;
  return what + ": the receive buffer has " + std::to_string(granted_bytes_) +
         " bytes; allow more with 'sysctl -w net.core.rmem_max=" +
         std::to_string(kReceiveBufferBytes) + "' (and recv_buf_size, if the URL has it)";
}

}  // namespace egomod
