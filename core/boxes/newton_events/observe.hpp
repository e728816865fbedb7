// State and observables at the current time. Groups are integrated in a copy.
#pragma once
#include <algorithm>
#include <optional>
#include <vector>

#include "clusters.hpp"
#include "groups.hpp"
#include "ledger.hpp"

namespace hardlimit::boxes::events {

// All groups, integrated up to the current time.
struct GroupsAtPresent {
    struct Body {
        int index;
        Vector3 position, velocity;  // in the frame of its cell
        Vector3 spin{};
    };
    Observation sums;  // over the whole run, without the motion of the bodies
    std::vector<Body> bodies;
    std::vector<ContactRecord> open;  // open contacts, and ended contacts of unfinished groups
};

template <class Law>
struct Observer {
    using Group = ContactGroup<Law>;

    const Paths<Law>& paths;
    const Groups<Law>& groups;
    const Frames<Law>& frames;
    const Clusters<Law>& clusters;
    const Ledger<Law>& ledger;
    mutable std::optional<GroupsAtPresent> present{};  // until forget()

    Observation observe() const {
        Observation o = groups_at_present().sums;
        if (paths.box.is_sheared() || paths.box.falls())
            add_motion(o);
        else
            add_velocities(o);
        if constexpr (FrictionalLaw<Law>) add_spins(o);
        return o;
    }
    // Writes 3 n values, by original index.
    void spins(double* spin) const
        requires FrictionalLaw<Law>
    {
        for_spins([&](int i, const Vector3& w) {
            std::copy_n(w.data(), 3, spin + 3 * std::size_t{paths.pending[i].original_index});
        });
    }
    // Writes n·d values each, by original index: positions and velocities with those of the images.
    void state(double* position, double* velocity) const {
        const auto d = static_cast<std::size_t>(paths.box.dimension);
        for_bodies([&](int i, const Vector3& x, const Vector3& v) {
            const BodyEvents& e = paths.pending[i];
            const std::size_t at = d * std::size_t{e.original_index};
            const ImageMotion image = paths.box.image(e.image_flags, paths.now);
            for (std::size_t a = 0; a < d; ++a) {
                position[at + a] = x[a] + image.shift[a];
                velocity[at + a] = v[a] + image.velocity[a];
            }
        });
    }
    // Integrating the groups is expensive, and a sample is often followed by the state at the same time.
    const GroupsAtPresent& groups_at_present() const {
        if (present) return *present;
        present.emplace().sums = ledger.sums;
        Cluster<Law> c;
        groups.for_all([&](int, const Group& g) { add_group(*present, g, c); });
        return *present;
    }
    // Must be called when anything changes.
    void forget() { present.reset(); }

private:
    // Calls f(i, position, velocity) for every body at the current time, in the order of memory and then by group.
    template <class F>
    void for_bodies(const F& f) const {
        for (int i = 0; i < paths.size(); ++i)
            if (paths.free(i)) f(i, paths.position(i, paths.now), paths.velocity(i, paths.now));
        for (const auto& body : groups_at_present().bodies) f(body.index, body.position, body.velocity);
    }
    template <class F>
    void for_spins(const F& f) const {
        for (int i = 0; i < paths.size(); ++i)
            if (paths.free(i)) f(i, paths.rotations[static_cast<std::size_t>(i)].spin);
        for (const auto& body : groups_at_present().bodies) f(body.index, body.spin);
    }
    void add_spins(Observation& o) const {
        for_spins([&](int i, const Vector3& w) {
            const double inertia = paths.rotations[static_cast<std::size_t>(i)].inertia;
            o.rotational_energy += 0.5 * inertia * dot(w, w);
            for (std::size_t a = 0; a < 3; ++a) o.spin.component[a] += inertia * w[a];
        });
    }
    void add_motion(Observation& o) const {
        for_bodies([&](int i, const Vector3& x, Vector3 v) {
            const double m = paths.mass(i);
            const ImageMotion image = paths.box.image(paths.pending[i].image_flags, paths.now);
            const double flow = to_image_in_box(paths.box, o, m, x, v);
            for (std::size_t a = 0; a < static_cast<std::size_t>(paths.box.dimension); ++a) {
                o.kinetic_energy += 0.5 * m * v[a] * v[a];
                o.potential_energy -= m * paths.box.gravity[a] * (x[a] + image.shift[a]);
                o.momentum[a] += m * v[a];
            }
            v[0] -= flow;
            o.kinetic_tensor.add_square(m, v);
        });
    }
    // The same where no position matters.
    void add_velocities(Observation& o) const {
        Vector3 momentum{};
        SymmetricTensor kinetic;
        const auto add = [&](int i, const auto& v) {
            const double m = paths.mass(i);
            for (std::size_t a = 0; a < 3; ++a) momentum[a] += m * v[a];
            kinetic.add_square(m, v);
        };
        for (int i = 0; i < paths.size(); ++i)
            if (paths.free(i)) add(i, paths.particles[i].velocity);
        for (const auto& body : groups_at_present().bodies) add(body.index, body.velocity);
        std::ranges::copy(momentum, o.momentum);
        o.kinetic_tensor = kinetic;
        o.kinetic_energy = 0.5 * kinetic.trace();
    }
    // Adds a group, integrated in c up to the current time.
    void add_group(GroupsAtPresent& all, const Group& g, Cluster<Law>& c) const {
        Observation& o = all.sums;
        if (!g.isolated || !set_isolated_contact(g, c)) {
            clusters.set_initial(g, c);
            c.run_through(paths.now - c.base);
        }
        const double tangential = c.tangential(), slack = c.stored(ContactState::slack) + tangential;
        o.contact_energy += c.stored(ContactState::closed) + slack;
        o.tangential_energy += tangential;
        o.friction_loss -= tangential;
        add_cluster(o, c, c.dissipated - slack, c.given_to_walls(),
                    frames.shear_work(g, [&](std::size_t m) { return c.members[m].velocity; }));
        for (std::size_t m = 0; m < g.body.size(); ++m)
            all.bodies.push_back({g.body[m], frames.body_position(g, m, c.members[m].position, paths.now),
                                  frames.body_velocity(g, m, c.members[m].velocity),
                                  c.rotations.empty() ? Vector3{} : c.rotations[m].spin});
        for (const EndedContact& e : c.ended) {
            count_end(o, e);
            all.open.push_back(ledger.row(g, c.pairs[static_cast<std::size_t>(e.pair)], e));
        }
        for (const ContactPair<Law>& q : c.pairs) {
            if (q.state != ContactState::closed) continue;
            ++o.in_contact;
            EndedContact open{0, q.begin, math::nan, q.impact_speed, math::nan, q.overlapped};
            if constexpr (FrictionalLaw<Law>)
                open.slid = q.surfaces.slid, open.tangential_speed = length(q.surfaces.slip);
            all.open.push_back(ledger.row(g, q, open));
        }
    }
    // Sets c to the present state of an isolated contact of two bodies, by power series from touch or from the end of
    // its force, whichever is nearer: mostly in one step. Returns false if it must be integrated instead. Backward,
    // errors grow as the motion is damped, so that a contact that loses most of its speed is not solved from its end.
    bool set_isolated_contact(const Group& g, Cluster<Law>& c) const {
        if constexpr (LinearLaw<Law> && FrictionlessLaw<Law>) {
            constexpr double least_restitution = 0.3;
            const IsolatedContact<Law>& l = g.isolated_contact;
            const EndedContact& whole = l.contact;
            const double now = paths.now;
            if (l.pair.second < 0 || paths.box.is_sheared() ||
                whole.separation_speed < least_restitution * whole.impact_speed)
                return false;
            clusters.set_initial(g, c);
            ContactPair<Law>& q = c.pairs[0];
            if (now - whole.begin > whole.end - now) {
                const double from = math::max(whole.end, now);
                for (std::size_t m = 0; m < 2; ++m) {
                    const Vector3 x = paths.position(g.body[m], from);
                    const ImageMotion image = frames.cell_frame(g, m, from);
                    for (std::size_t a = 0; a < 3; ++a)
                        c.members[m].position[a] = x[a] - (g.origin[a] + image.shift[a]);
                    c.members[m].velocity = paths.velocity(g.body[m], from);
                }
                c.time = from - c.base;
                c.dissipated = l.dissipated - c.stored(ContactState::closed);
                c.virial = l.virial;
            }
            if (now < whole.end) {
                if (!c.move_to(now - c.base)) return false;
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
};

}  // namespace hardlimit::boxes::events
