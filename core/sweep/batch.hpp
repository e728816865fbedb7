// The drops of one batch as a structure of arrays: input and output of a vector kernel.
#pragma once
#include <cstring>

#include "kernel_abi.hpp"
#include "parameters.hpp"

namespace hardlimit::sweep {

using hardlimit_abi::Status;

template <int most>
struct Drops {
    static constexpr int room =
        most + 8;  // padding, so that equal indices of all arrays do not share one cache set
    int count, status[most];
    double in[10][room], out[6][room], speed[room], rate[room];

    void add(const column::Start& s) {
        const double values[10] = {s.groups.a1, s.groups.a2, s.groups.c1, s.groups.c2, s.groups.gravity,
                                   s.first.u,   s.first.du,  s.first.w,   s.first.dw,  s.t};
        for (int j = 0; j < 10; ++j) in[j][count] = values[j];
        speed[count] = s.units.speed;
        rate[count] = s.units.rate;
        ++count;
    }
    hardlimit_abi::Batch batch() {
        return {count, in[0], in[1],  in[2],  in[3],  in[4],  in[5],  in[6],  in[7],
                in[8], in[9], out[0], out[1], out[2], out[3], out[4], out[5], status};
    }

    // Valid after the kernel has run. left: the scalar solver must solve this drop.
    bool left(int k) const { return status[k] == static_cast<int>(Status::left); }
    Outcome outcome(int k) const {
        return status[k] == static_cast<int>(Status::rests) ? Outcome::at_rest : Outcome::ok;
    }
    int n_contacts(int k) const { return static_cast<int>(out[0][k]); }
    column::Sequence sequence(int k) const {
        const Found found = {out[0][k], out[1][k], out[2][k], out[3][k], out[4][k], out[5][k]};
        return sequence_of(found, {speed[k], rate[k]}, outcome(k));
    }
};

// Vector form of leave() in parameters.hpp for a whole batch, without the numbers of contacts.
template <class R>
HL_FN void leave_batch(const hardlimit_abi::Ends& ends) {
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
