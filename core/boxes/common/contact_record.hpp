// What both engines of Newton's equations tell of a contact.
#pragma once
#include <cstdint>

namespace hardlimit::boxes {

// One contact of the log. second < 0: −1 − 2·axis for the wall at 0, −2 − 2·axis for that at the far edge.
struct ContactRow {
    double begin, end;  // [s]; end is NaN where it is still open
    std::int32_t first, second;
    double impact_speed, separation_speed;  // [m/s]
    bool overlapped;                        // shared a body with another contact while it lasted
};

}  // namespace hardlimit::boxes
