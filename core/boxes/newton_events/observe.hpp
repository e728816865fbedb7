// State, observables and log rows of the event-driven engine.
#pragma once
#include "engine.hpp"

namespace hardlimit::boxes {

// Integrating the groups is expensive, and a sample is often followed by the state at the same time.
template <class Law>
const GroupsAtPresent& NewtonEvents<Law>::groups_at_present() const {
    if (groups_at_present_) return *groups_at_present_;
    GroupsAtPresent& present = groups_at_present_.emplace();
    Observation& o = present.sums;
    o.dissipated_energy = dissipated_, o.virial = virial_, o.largest_compression = largest_compression_;
    o.wall_work = wall_work_, o.shear_work = shear_work_, o.walls = walls_;
    o.begun = begun_, o.pairs = begun_pairs_, o.ended = ended_, o.overlapped = overlapped_;
    Cluster<Law> c;
    for (const Group& g : groups_)
        if (g.alive) add_group(present, g, c);
    return present;
}

// Adds a group, integrated in c up to the current time.
template <class Law>
void NewtonEvents<Law>::add_group(GroupsAtPresent& present, const Group& g, Cluster<Law>& c) const {
    Observation& o = present.sums;
    if (!g.isolated || !set_present_contact(g, c)) {
        initial_cluster(g, c);
        c.run_through(now_ - c.base);
    }
    const double slack = c.stored(ContactState::slack);
    o.walls += c.given_to_walls();
    o.contact_energy += c.stored(ContactState::closed) + slack;
    o.dissipated_energy += c.dissipated - slack;
    o.virial += c.virial;
    o.wall_work += c.wall_work;
    o.shear_work += c.shear_work + shear_work(g, [&](std::size_t m) { return c.members[m].velocity; });
    o.largest_compression = math::max(o.largest_compression, c.largest_compression);
    o.begun += static_cast<u64>(c.begun);
    o.pairs += static_cast<u64>(c.begun_pairs);
    for (std::size_t m = 0; m < g.body.size(); ++m)
        present.bodies.push_back({g.body[m], body_position(g, m, c.members[m].position, now_),
                                  body_velocity(g, m, c.members[m].velocity)});
    for (const EndedContact& e : c.ended) {
        ++o.ended;
        o.overlapped += e.overlapped;
        present.open.push_back(contact_row(g, c.pairs[static_cast<std::size_t>(e.pair)], e));
    }
    for (const ContactPair<Law>& q : c.pairs) {
        if (q.state != ContactState::closed) continue;
        ++o.in_contact;
        present.open.push_back(
            contact_row(g, q, {0, q.begin, math::nan, q.impact_speed, math::nan, q.overlapped}));
    }
}

// Sets c to the present state of an isolated contact of two bodies, by power series from touch or from the end of its
// force, whichever is nearer: mostly in one step. Returns false if it must be integrated instead. Backward, errors grow
// as the motion is damped, so that a contact that loses most of its speed is not solved from its end.
template <class Law>
bool NewtonEvents<Law>::set_present_contact(const Group& g, Cluster<Law>& c) const {
    if constexpr (LinearLaw<Law>) {
        constexpr double least_restitution = 0.3;
        const IsolatedContact& l = g.isolated_contact;
        const EndedContact& whole = l.contact;
        if (l.pair.second < 0 || box_.is_sheared() ||
            whole.separation_speed < least_restitution * whole.impact_speed)
            return false;
        initial_cluster(g, c);
        ContactPair<Law>& q = c.pairs[0];
        if (now_ - whole.begin > whole.end - now_) {
            const double from = math::max(whole.end, now_);
            for (std::size_t m = 0; m < 2; ++m) {
                const Vector3 x = position(g.body[m], from);
                const ImageMotion image = cell_frame(g, m, from);
                for (std::size_t a = 0; a < 3; ++a)
                    c.members[m].position[a] = x[a] - (g.origin[a] + image.shift[a]);
                c.members[m].velocity = velocity(g.body[m], from);
            }
            c.time = from - c.base;
            c.dissipated = l.dissipated - c.stored(ContactState::closed);
            c.virial = l.virial;
        }
        if (now_ < whole.end) {
            if (!c.move_to(now_ - c.base)) return false;
        } else {
            q.state = ContactState::slack;
            c.dissipated = l.dissipated;
            c.ended.push_back(whole);
        }
        const double least = math::min(l.before[0].radius, l.before[1].radius);
        c.largest_compression =
            math::max(c.largest_compression, c.rate(q) > 0.0 ? -c.gap(q) / least : g.compression);
        return true;
    }
    return false;
}

// Calls f(i, position, velocity) for every body at the current time, in the order of memory and then by group.
template <class Law>
template <class F>
void NewtonEvents<Law>::for_bodies(const F& f) const {
    for (int i = 0; i < static_cast<int>(particles_.size()); ++i)
        if (free(i)) f(i, position(i, now_), velocity(i, now_));
    for (const auto& [i, x, v] : groups_at_present().bodies) f(i, x, v);
}

template <class Law>
Observation NewtonEvents<Law>::observe() const {
    Observation o = groups_at_present().sums;
    if (!box_.is_sheared() && dot(gravity_, gravity_) == 0.0) {  // no position matters
        Vector3 momentum{};
        SymmetricTensor kinetic;
        const auto add = [&](int i, const auto& v) {
            const double m = mass(i);
            for (std::size_t a = 0; a < 3; ++a) momentum[a] += m * v[a];
            kinetic.add_square(m, v);
        };
        for (int i = 0; i < static_cast<int>(particles_.size()); ++i)
            if (free(i)) add(i, particles_[i].velocity);
        for (const auto& body : groups_at_present().bodies) add(body.index, body.velocity);
        std::ranges::copy(momentum, o.momentum);
        o.kinetic_tensor = kinetic;
        o.kinetic_energy = 0.5 * kinetic.trace();
        return o;
    }
    for_bodies([&](int i, const Vector3& x, Vector3 v) {
        const double m = mass(i);
        const ImageMotion image = box_.image(pending_[i].image_flags, now_);
        const double flow = box_.is_sheared() ? to_image_in_box(box_, o, m, x, v) : 0.0;
        for (std::size_t a = 0; a < setting_.axes(); ++a) {
            o.kinetic_energy += 0.5 * m * v[a] * v[a];
            o.potential_energy -= m * box_.gravity[a] * (x[a] + image.shift[a]);
            o.momentum[a] += m * v[a];
        }
        v[0] -= flow;
        o.kinetic_tensor.add_square(m, v);
    });
    return o;
}

template <class Law>
void NewtonEvents<Law>::state(double* position, double* velocity) const {
    const std::size_t d = setting_.axes();
    for_bodies([&](int i, const Vector3& x, const Vector3& v) {
        const std::size_t at = d * std::size_t{pending_[i].original_index};
        const ImageMotion image = box_.image(pending_[i].image_flags, now_);
        for (std::size_t a = 0; a < d; ++a) {
            position[at + a] = x[a] + image.shift[a];
            velocity[at + a] = v[a] + image.velocity[a];
        }
    });
}

// cluster_share: fraction of the bodies' time spent in clusters.
template <class Law>
std::vector<Statistic> NewtonEvents<Law>::statistics() const {
    const double time = now_ * static_cast<double>(size());
    return {{"n_events", static_cast<double>(events_)},
            {"largest_cluster", static_cast<double>(largest_cluster_)},
            {"cluster_share", now_ > 0.0 ? clustered_ / time : 0.0}};
}

template <class Law>
std::size_t NewtonEvents<Law>::bytes() const {
    const auto of = [](const auto& v) { return v.capacity() * sizeof(v[0]); };
    return sizeof *this + of(particles_) + of(pending_) + of(groups_) + of(candidates_) + of(times_) +
           cells_.bytes() + calendar_queue_.bytes();
}

template <class Law>
void NewtonEvents<Law>::log(const Group& g, const ContactPair<Law>& q, const EndedContact& e) {
    ++ended_;
    overlapped_ += e.overlapped;
    if (setting_.log) log_.push_back(contact_row(g, q, e));
}

template <class Law>
ContactRecord NewtonEvents<Law>::contact_row(const Group& g, const ContactPair<Law>& q,
                                             const EndedContact& e) const {
    const auto index = [&](int member) {
        return static_cast<int>(pending_[g.body[static_cast<std::size_t>(member)]].original_index);
    };
    int first = index(q.first), second = q.second >= 0 ? index(q.second) : q.wall_id.number;
    if (second >= 0 && second < first) std::swap(first, second);
    return {e.begin, e.end, first, second, e.impact_speed, e.separation_speed, e.overlapped};
}

}  // namespace hardlimit::boxes
