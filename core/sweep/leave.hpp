// The way out of a vector kernel: sequences of a block from scaled units to what a sweep keeps.
#pragma once
#include <cstring>

#include "kernel_abi.hpp"
#include "parameters.hpp"

namespace hardlimit::sweep {

// leave() of parameters.hpp for the drops of a block, all but what is counted.
template <class R>
HL_FN void leave_block(const hardlimit_abi::Ends& ends) {
    struct {
        R t_first_touch, t_end, t_floor_end, relative_velocity, separation_velocity;
    } q;
    R speed, rate, restitution;
    for (int i = 0; i < ends.count; i += Lanes<R>::count) {
        const auto read = [i](R& to, const double* from) { std::memcpy(&to, from + i, sizeof(R)); };
        const auto write = [i](double* to, const R& from) { std::memcpy(to + i, &from, sizeof(R)); };
        read(speed, ends.speed);
        read(rate, ends.rate);
        read(restitution, ends.restitution);
        read(q.t_first_touch, ends.t_first);
        read(q.t_end, ends.t_end);
        read(q.t_floor_end, ends.t_floor_end);
        read(q.relative_velocity, ends.relative);
        read(q.separation_velocity, ends.separation);
        column::to_si(q, speed, rate);
        Quantities<R> r;
        keep(q, restitution, speed, r);
        write(ends.relative, r.relative_velocity);
        write(ends.separation, r.separation_velocity);
        write(ends.effective_restitution, r.effective_restitution);
        write(ends.restitution_ratio, r.restitution_ratio);
        write(ends.t_end, r.t_end);
        write(ends.t_floor_end, r.t_floor_end);
    }
}

}  // namespace hardlimit::sweep
