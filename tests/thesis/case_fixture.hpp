// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <string>

namespace egomod::thesis {

// A case of which everything is known: 10 Hz, 31 pairs, f 500 px, cx 320, baseline 0.4 m. The rig
// goes ahead at 0.5 m/s, the target, 200 px wide, starts 5 m before the first camera and 1 m to its
// left, at 1 m/s. Both methods know the rig's way exactly. The thesis's reports the target in pairs
// 10, 20 and 30, the default in all from 5 on, 0.1 m too far and 0.25 m/s too fast. A pair takes
// 2 ms and 6 ms. Further runs of the thesis's, thesis-narrow and thesis-wide, are as its first.
void write_case(const std::string& folder);

}  // namespace egomod::thesis
