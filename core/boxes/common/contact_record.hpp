// One row of the contact log of both engines for Newton's equations.
#pragma once
#include <cstdint>

namespace hardlimit::boxes {

// second < 0 is a wall: −1 − 2·axis at 0, −2 − 2·axis at the far edge.
struct ContactRecord {
    double begin, end;  // [s]; end is NaN while the contact is open
    std::int32_t first, second;
    double impact_speed, separation_speed;  // [m/s]
    bool overlapped;                        // a body had another contact at the same time
};

}  // namespace hardlimit::boxes
