// The drops of one batch as a structure of arrays: input and output of a vector kernel.
#pragma once
#include <cstring>

#include "kernel_abi.hpp"
#include "parameters.hpp"

namespace hardlimit::sweep {

using hardlimit_abi::Status;

template <int most>
struct Drops {
    static constexpr int inputs = hardlimit_abi::batch_inputs, outputs = hardlimit_abi::batch_outputs;
    static constexpr int room =
        most + 8;  // padding: equal indices of all arrays must not share one cache set
    int count, status[most];
    double in[inputs][room], out[outputs][room], speed[room], rate[room];

    void add(const column::Start& s) {
        const double values[inputs] = {s.groups.a1, s.groups.a2, s.groups.c1, s.groups.c2, s.groups.gravity,
                                       s.first.u,   s.first.du,  s.first.w,   s.first.dw,  s.t};
        for (int j = 0; j < inputs; ++j) in[j][count] = values[j];
        speed[count] = s.units.speed;
        rate[count] = s.units.rate;
        ++count;
    }
    hardlimit_abi::Batch batch() {
        hardlimit_abi::Batch b{count, {}, {}, status};
        for (int j = 0; j < inputs; ++j) b.in[j] = in[j];
        for (int j = 0; j < outputs; ++j) b.out[j] = out[j];
        return b;
    }

    // Valid after the kernel has run. unsolved: the scalar solver must solve this drop.
    bool unsolved(int k) const { return status[k] == static_cast<int>(Status::unsolved); }
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
        const Quantities<R> r = quantities_of(q, restitution, speed);
        double* const to[quantity_count] = {
            ends.relative,          ends.separation, ends.effective_restitution,
            ends.restitution_ratio, ends.t_end,      ends.t_floor_end};
        for (int k = 0; k < quantity_count; ++k) write(to[k], r.of[k]);
    }
}

}  // namespace hardlimit::sweep
