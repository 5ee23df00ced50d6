// SPDX-License-Identifier: Apache-2.0
#include "replay_report.hpp"

#include <fmt/format.h>

#include <algorithm>

namespace egomod {
namespace {

std::uint64_t rejected_for(PairFault fault, const PipelineStatistics& pipeline) {
  return pipeline.rejected_by[static_cast<std::size_t>(fault)];
}

std::string rejections(const PipelineStatistics& pipeline) {
  const std::pair<PairFault, const char*> reasons[] = {
      {PairFault::kNoPartner, "without an image of the right camera"},
      {PairFault::kSkew, "whose images are too far apart in time"},
      {PairFault::kDamaged, "with a damaged image"},
  };
  std::string text;
  for (const auto& [fault, reason] : reasons) {
    if (const std::uint64_t count = rejected_for(fault, pipeline); count > 0) {
      text += fmt::format("{}{} {}", text.empty() ? ": " : ", ", count, reason);
    }
  }
  return fmt::format("{} of {} pairs were rejected{}", pipeline.rejected, pipeline.captured, text);
}

}  // namespace

std::vector<std::string> losses_of(const PipelineStatistics& pipeline,
                                   const PublishStatistics& publish, const SourceCounters& source) {
  std::vector<std::string> losses;
  if (pipeline.rejected > 0) {
    losses.push_back(rejections(pipeline));
  }
  if (source.lost_images + source.dropped_images > 0) {
    losses.push_back(
        fmt::format("{} images never came from the source, {} came too late or were "
                    "not taken in time",
                    source.lost_images, source.dropped_images));
  }
  if (source.damaged_messages > 0) {
    losses.push_back(fmt::format(
        "{} image messages were too damaged to tell their time: no pairs stand for them, and those "
        "after them have lower numbers",
        source.damaged_messages));
  }
  if (publish.not_finite > 0) {
    losses.push_back(fmt::format("{} estimates were not finite and held back", publish.not_finite));
  }
  return losses;
}

std::string why_nothing_was_used(const PipelineStatistics& pipeline) {
  if (pipeline.captured == 0 || pipeline.captured > pipeline.rejected + pipeline.skipped) {
    return {};
  }
  const auto most = std::ranges::max_element(pipeline.rejected_by) - pipeline.rejected_by.begin();
  switch (static_cast<PairFault>(most)) {
    case PairFault::kNoPartner:
      return "no pair could be used, there are no images of the right camera: was it recorded, and "
             "does capture.right_channel name its channel (egomod-log info lists them)?";
    case PairFault::kSkew:
      return fmt::format(
          "no pair could be used, the nearest right image is {} s from its left one: do both "
          "cameras share a clock, and is capture.max_skew_s large enough?",
          to_seconds(pipeline.least_rejected_skew));
    case PairFault::kDamaged:
      return "no pair could be used, all have a damaged image: record them anew";
    case PairFault::kNone:
      break;
  }
  return "no pair could be used";
}

}  // namespace egomod
