// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <string>
#include <vector>

#include "egomod/capture/frame_source.hpp"
#include "egomod/pipeline/pipeline_statistics.hpp"
#include "egomod/publish/publisher.hpp"

namespace egomod {

// What a replay has left out or held back, with counts; a sentence each. (A live run says it while
// it runs, as health.)
[[nodiscard]] std::vector<std::string> losses_of(const PipelineStatistics& pipeline,
                                                 const PublishStatistics& publish,
                                                 const SourceCounters& source);

// Why not one pair of a replay could be used, with the remedy; empty if one could, or none was.
[[nodiscard]] std::string why_nothing_was_used(const PipelineStatistics& pipeline);

}  // namespace egomod
