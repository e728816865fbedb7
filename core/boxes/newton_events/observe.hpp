// State and observables at the current time. Groups are integrated in a copy.
#pragma once
#include <algorithm>
#include <vector>

#include "clusters.hpp"
#include "groups.hpp"
#include "present_contacts.hpp"

namespace hardlimit::boxes::events {

template <class Law>
struct Observer {
    using Group = ContactGroup<Law>;

    const Paths<Law>& paths;
    const Groups<Law>& groups;
    const Frames<Law>& frames;
    const Clusters<Law>& clusters;
    const Ledger<Law>& ledger;
    const hardlimit_abi::SampleKernels& kernels;
    // Storage.
    mutable PresentContacts<Law> contacts{paths, frames, ledger, kernels};
    mutable Cluster<Law> cluster{};
    mutable GroupsAtPresent present{};
    mutable bool known = false;  // whether `present` is, until forget()

    Observation observe() const {
        const bool moves = paths.box.is_sheared() || paths.box.falls();  // whether positions matter
        Observation o = groups_at_present(moves).sums;
        moves ? add_motion(o) : add_velocities(o);
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
    // Integrating the groups is expensive, and a sample is often taken with the state at the same time.
    const GroupsAtPresent& groups_at_present(bool detailed) const {
        if (known && present.detailed >= detailed) return present;
        present.reset(ledger.sums, detailed);
        known = true;
        const auto integrate = [&](const Group& g) { add_group(present, g, cluster); };
        if constexpr (LinearLaw<Law> && FrictionlessLaw<Law>) {
            contacts.clear();
            groups.for_all([&](int, const Group& g) {
                if (!contacts.take(g)) integrate(g);
            });
            contacts.add_to(present, integrate);
        } else
            groups.for_all([&](int, const Group& g) { integrate(g); });
        return present;
    }
    // Must be called when anything changes.
    void forget() { known = false; }

private:
    // Calls f(i, position, velocity) for every body at the current time, in the order of memory and then by group.
    template <class F>
    void for_bodies(const F& f) const {
        for (int i = 0; i < paths.size(); ++i)
            if (paths.free(i)) f(i, paths.position(i, paths.now), paths.velocity(i, paths.now));
        for (const auto& body : groups_at_present(true).bodies) f(body.index, body.position, body.velocity);
    }
    template <class F>
    void for_spins(const F& f) const {
        for (int i = 0; i < paths.size(); ++i)
            if (paths.free(i)) f(i, paths.rotations[static_cast<std::size_t>(i)].spin);
        for (const auto& body : groups_at_present(false).bodies) f(body.index, body.spin);
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
        const auto& kinds = paths.laws().kinds();
        const auto& kind = paths.laws().kind_of_bodies();
        kernels.sum_velocities(
            paths.particles.data(), paths.particles.size(),
            {&kinds[0].first, kind.empty() ? nullptr : kind.data(), kinds.size() == 1 ? 0u : 1u}, o.momentum,
            o.kinetic_tensor.component);
        for (const auto& body : groups_at_present(false).bodies) {
            const double m = paths.mass(body.index);
            for (std::size_t a = 0; a < 3; ++a) o.momentum[a] += m * body.velocity[a];
            o.kinetic_tensor.add_square(m, body.velocity);
        }
        o.kinetic_energy = 0.5 * o.kinetic_tensor.trace();
    }
    // Adds a group, integrated in c up to the current time.
    void add_group(GroupsAtPresent& all, const Group& g, Cluster<Law>& c) const {
        Observation& o = all.sums;
        clusters.set_initial(g, c);
        c.run_through(paths.now - c.base);
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
            if (all.detailed) all.open.push_back(ledger.row(g, c.pairs[static_cast<std::size_t>(e.pair)], e));
        }
        for (const ContactPair<Law>& q : c.pairs) {
            if (q.state != ContactState::closed) continue;
            ++o.in_contact;
            if (!all.detailed) continue;
            EndedContact open{0, q.begin, math::nan, q.impact_speed, math::nan, q.overlapped};
            if constexpr (FrictionalLaw<Law>)
                open.slid = q.surfaces.slid, open.tangential_speed = length(q.surfaces.slip);
            all.open.push_back(ledger.row(g, q, open));
        }
    }
};

}  // namespace hardlimit::boxes::events
