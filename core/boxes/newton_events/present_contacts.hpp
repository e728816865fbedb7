// Isolated contacts of two bodies under a linear law at the current time, from power series in the plane of their
// approach (kernels/open_contacts.hpp).
#pragma once
#include <array>
#include <cstddef>
#include <vector>

#include "../kernels/interface.hpp"
#include "frames.hpp"
#include "ledger.hpp"

namespace hardlimit::boxes::events {

// All groups at the current time.
struct GroupsAtPresent {
    struct Body {
        int index;
        Vector3 position, velocity;  // in the frame of its cell
        Vector3 spin{};
    };
    bool detailed = false;  // whether positions and `open` are known
    Observation sums;       // over the whole run, without the motion of the bodies
    std::vector<Body> bodies;
    std::vector<ContactRecord> open;  // open contacts, and ended contacts of unfinished groups

    void reset(const Observation& of_run, bool details) {
        detailed = details, sums = of_run;
        bodies.clear(), open.clear();
    }
};

template <class Law>
class PresentContacts {
public:
    using Group = ContactGroup<Law>;

    PresentContacts(const Paths<Law>& paths, const Frames<Law>& frames, const Ledger<Law>& ledger,
                    const hardlimit_abi::SampleKernels& kernels)
        : paths_(paths), frames_(frames), ledger_(ledger), kernels_(kernels) {}

    void clear() { starts_.clear(), states_.clear(); }
    // Takes a group, whose contact is then solved from touch or from the end of its force, whichever is nearer. Returns
    // false if it must be integrated. Backward, errors grow as the motion is damped, so that a contact that loses most
    // of its speed is solved from touch.
    HL_FN_APART bool take(const Group& g) {
        constexpr double least_restitution = 0.3;
        const IsolatedContact<Law>& l = g.isolated_contact;
        const EndedContact& whole = l.contact;
        const ContactPair<Law>& q = l.pair;
        if (!g.isolated || q.second < 0 || q.image_moves) return false;
        const double since = paths_.now - whole.begin, left = whole.end - paths_.now;
        const bool damped = whole.separation_speed < least_restitution * whole.impact_speed;
        Start s{.group = &g, .distance = q.contact_distance, .time = since};
        s.normal = distance_at_touch(l);
        s.normal = (1.0 / math::sqrt(dot(s.normal, s.normal))) * s.normal;
        s.tangent = (l.before[1].velocity - l.before[0].velocity) + whole.impact_speed * s.normal;
        double radial = -whole.impact_speed, tangential = math::sqrt(dot(s.tangent, s.tangent));
        if (tangential > 0.0) s.tangent = (1.0 / tangential) * s.tangent;
        if (left <= 0.0 || (left < since && !damped)) {
            const auto turn = math::sincos(l.rotation);
            const Vector3 normal = s.normal;
            s.normal = turn.cos * normal + turn.sin * s.tangent;
            s.tangent = turn.cos * s.tangent - turn.sin * normal;
            s.depth = q.law.slack(-whole.separation_speed).depth;
            s.distance -= s.depth;
            s.time = -left;
            s.from_end = true;
            radial = whole.separation_speed;
            tangential *= q.contact_distance / s.distance;
        }
        if (s.time == 0.0) s.time = math::epsilon * l.span;
        const double per_mass = left > 0.0 ? 1.0 / q.mass : 0.0, per_distance = s.time / s.distance;
        hardlimit_abi::OpenContact& c = states_.emplace_back();
        c.spring = q.law.elastic_force(1.0) * per_mass * s.time * s.time;
        c.damper = q.law.force(0.0, 1.0) * per_mass * s.time;
        c.radial_speed = radial * per_distance;
        c.tangential_speed = tangential * per_distance;
        c.force = s.from_end ? 0.0 : -c.damper * c.radial_speed;
        starts_.push_back(s);
        return true;
    }
    // Adds the contacts that have been taken; calls integrate(group) if the series does not converge.
    template <class F>
    void add_to(GroupsAtPresent& all, const F& integrate) {
        kernels_.solve(states_.data(), states_.size());
        for (std::size_t i = 0; i < starts_.size(); ++i)
            if (converges(starts_[i], states_[i]))
                add(all, starts_[i], states_[i]);
            else
                integrate(*starts_[i].group);
    }

private:
    // Where the series of a contact starts: at touch, or at the end of its force.
    struct Start {
        const Group* group;
        Vector3 normal{}, tangent{};
        double distance, time;  // of the centres there [m]; from there until now [s]
        double depth = 0.0;     // there [m]
        bool from_end = false;
    };
    using State = hardlimit_abi::OpenContact;

    const Paths<Law>& paths_;
    const Frames<Law>& frames_;
    const Ledger<Law>& ledger_;
    const hardlimit_abi::SampleKernels& kernels_;
    std::vector<Start> starts_;
    std::vector<State> states_;

    static Vector3 distance_at_touch(const IsolatedContact<Law>& l) {
        return (l.before[1].position - l.before[0].position) + l.pair.image;
    }
    // Whether the last terms are below 1e-13 of the distance at impact speed until now or in the time 1/ω.
    static bool converges(const Start& s, const State& c) {
        const double speed = s.group->isolated_contact.contact.impact_speed * math::abs(s.time) / s.distance;
        return c.last_term * math::max(math::sqrt(c.spring), 1.0) <= 1e-13 * speed;
    }

    HL_FN_APART void add(GroupsAtPresent& all, const Start& s, const State& c) const {
        const Group& g = *s.group;
        const IsolatedContact<Law>& l = g.isolated_contact;
        const ContactPair<Law>& q = l.pair;
        Observation& o = all.sums;
        const bool ended = l.contact.end <= paths_.now;
        const double depth = s.depth - s.distance * c.stretched;
        add_energies(o, s, c, q.law.energy(math::max(depth, 0.0)), ended);
        add_virial(o, s, c);
        const double least = math::min(l.before[0].radius, l.before[1].radius);
        o.largest_compression =
            math::max(o.largest_compression, c.rate * s.time < 0.0 ? depth / least : g.compression);
        add_members(all, s, c);
        if (ended)
            count_end(o, l.contact);
        else
            ++o.in_contact;
        if (!all.detailed) return;
        const EndedContact open{0, l.contact.begin, math::nan, q.impact_speed, math::nan, q.overlapped};
        all.open.push_back(ledger_.row(g, q, ended ? l.contact : open));
    }
    // The energy that the pair stores at the end of its force is dissipated as the surfaces separate.
    void add_energies(Observation& o, const Start& s, const State& c, double stored, bool ended) const {
        const IsolatedContact<Law>& l = s.group->isolated_contact;
        o.contact_energy += stored;
        if (ended) {
            o.dissipated_energy += l.dissipated - stored;
            return;
        }
        const double before = s.from_end ? l.dissipated - l.pair.law.energy(s.depth) : 0.0;
        const double integral = (s.distance * s.distance / s.time) * c.rate_square;  // ∫ (dξ/dt)² dt
        o.dissipated_energy += before + l.pair.law.force(0.0, 1.0) * integral;
    }
    void add_virial(Observation& o, const Start& s, const State& c) const {
        const ContactPair<Law>& q = s.group->isolated_contact.pair;
        if (s.from_end) o.virial += s.group->isolated_contact.virial;
        const double action = q.mass * (s.distance * s.distance / s.time);
        const Vector3 along = c.virial_xx * s.normal + c.virial_xy * s.tangent;
        const Vector3 across = c.virial_xy * s.normal + c.virial_yy * s.tangent;
        o.virial.add_product(action, s.normal, along);
        o.virial.add_product(action, s.tangent, across);
    }
    void add_members(GroupsAtPresent& all, const Start& s, const State& c) const {
        const Group& g = *s.group;
        const Member(&before)[2] = g.isolated_contact.before;
        const double total = before[0].mass + before[1].mass;
        const double part[2] = {-before[1].mass / total, before[0].mass / total};
        const double since = paths_.now - g.isolated_contact.contact.begin, per_time = s.distance / s.time;
        const Vector3 pull = since * std::to_array(paths_.box.gravity);
        const Vector3 mean = part[1] * before[0].velocity + (-part[0]) * before[1].velocity;
        const Vector3 relative = (per_time * c.speed_x) * s.normal + (per_time * c.speed_y) * s.tangent;
        Vector3 velocity[2];
        for (std::size_t m = 0; m < 2; ++m) velocity[m] = (mean + pull) + part[m] * relative;
        all.sums.shear_work += frames_.shear_work(g, [&](std::size_t m) { return velocity[m]; });
        for (std::size_t m = 0; m < 2; ++m)
            all.bodies.push_back({g.body[m], {}, frames_.body_velocity(g, m, velocity[m])});
        if (!all.detailed) return;
        const Vector3 moved = since * (mean + 0.5 * pull);
        const Vector3 distance = (s.distance * c.x) * s.normal + (s.distance * c.y) * s.tangent;
        const Vector3 approached = distance - distance_at_touch(g.isolated_contact);
        for (std::size_t m = 0; m < 2; ++m)
            (all.bodies.end() - 2 + static_cast<std::ptrdiff_t>(m))->position =
                frames_.body_position(g, m, (before[m].position + moved) + part[m] * approached, paths_.now);
    }
};

}  // namespace hardlimit::boxes::events
