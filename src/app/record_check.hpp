// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <span>
#include <string>

#include "egomod/app/config.hpp"

namespace egomod {

// Opening the record empties it. Throws RecordError where it is, by whatever name, what the run
// reads: the source's log, world or a file of its folder, the rig file, or one of `configuration`.
void refuse_record_over_inputs(const DaemonConfig& daemon,
                               std::span<const std::string> configuration = {});

}  // namespace egomod
