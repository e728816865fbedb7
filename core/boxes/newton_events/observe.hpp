// State, observables and log rows of the event-driven engine.
#pragma once
#include "engine.hpp"

namespace hardlimit::boxes {

template <class Law>
NewtonObservation NewtonEvents<Law>::observe() const {
    NewtonObservation s;
    s.position.resize(3 * particles_.size());
    s.velocity.resize(3 * particles_.size());
    s.dissipated = dissipated_;
    s.virial = virial_;
    s.largest_compression = largest_compression_;
    s.begun = begun_, s.begun_pairs = begun_pairs_, s.ended = ended_, s.overlapped = overlapped_;
    for (int i = 0; i < static_cast<int>(particles_.size()); ++i)
        if (free(i)) add_body(s, i, position(i, now_), velocity(i, now_));
    Cluster<Law> c;
    for (const Group& g : groups_)
        if (g.alive) add_group(s, g, c);
    return s;
}

template <class Law>
void NewtonEvents<Law>::add_body(NewtonObservation& s, int i, const Vector3& x, const Vector3& v) const {
    const std::size_t at = 3 * std::size_t{pending_[i].original_index};
    const double m = mass(i);
    for (std::size_t a = 0; a < 3; ++a) {
        s.position[at + a] = x[a] + pending_[i].image_flags[a] * box_.edge[a];
        s.velocity[at + a] = v[a];
        s.kinetic += 0.5 * m * v[a] * v[a];
        s.potential -= m * box_.gravity[a] * s.position[at + a];
        s.momentum[a] += m * v[a];
    }
}

// Adds a group, integrated in c up to the current time.
template <class Law>
void NewtonEvents<Law>::add_group(NewtonObservation& s, const Group& g, Cluster<Law>& c) const {
    initial_cluster(g, c);
    c.run_through(now_ - c.base);
    const double slack = c.stored(ContactState::slack);
    s.contact += c.stored(ContactState::closed) + slack;
    s.dissipated += c.dissipated - slack;
    s.virial += c.virial;
    s.largest_compression = math::max(s.largest_compression, c.largest_compression);
    s.begun += static_cast<std::uint64_t>(c.begun);
    s.begun_pairs += static_cast<std::uint64_t>(c.begun_pairs);
    for (std::size_t m = 0; m < g.body.size(); ++m)
        add_body(s, g.body[m], body_position(g, m, c.members[m].position), c.members[m].velocity);
    for (const EndedContact& e : c.ended) {
        ++s.ended;
        s.overlapped += e.overlapped;
        s.open.push_back(contact_row(g, c.pairs[static_cast<std::size_t>(e.pair)], e));
    }
    for (const ContactPair<Law>& q : c.pairs) {
        if (q.state != ContactState::closed) continue;
        ++s.in_contact;
        s.open.push_back(contact_row(g, q, {0, q.begin, math::nan, q.impact_speed, math::nan, q.overlapped}));
    }
}

template <class Law>
double NewtonEvents<Law>::cluster_share() const {
    return now_ > 0.0 ? clustered_ / (now_ * static_cast<double>(particles_.size())) : 0.0;
}

template <class Law>
void NewtonEvents<Law>::log(const Group& g, const ContactPair<Law>& q, const EndedContact& e) {
    ++ended_;
    overlapped_ += e.overlapped;
    if (keep_log_) log_.push_back(contact_row(g, q, e));
}

template <class Law>
typename NewtonEvents<Law>::Row NewtonEvents<Law>::contact_row(const Group& g, const ContactPair<Law>& q,
                                                               const EndedContact& e) const {
    const auto index = [&](int member) {
        return static_cast<int>(pending_[g.body[static_cast<std::size_t>(member)]].original_index);
    };
    int first = index(q.first), second = q.second >= 0 ? index(q.second) : wall_number(q);
    if (second >= 0 && second < first) std::swap(first, second);
    return {e.begin, e.end, first, second, e.impact_speed, e.separation_speed, e.overlapped};
}

}  // namespace hardlimit::boxes
