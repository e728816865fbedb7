// What happens at an event of a body: it leaves its cell, or a contact begins, is disturbed, or ends.
#pragma once
#include "formation.hpp"

namespace hardlimit::boxes::events {

template <class Law>
struct ContactEvents {
    using Group = ContactGroup<Law>;

    Paths<Law>& paths;
    BodyCells<Law>& cells;
    Groups<Law>& groups;
    const Frames<Law>& frames;
    IsolatedContacts<Law>& isolated;
    Membership<Law>& members;
    Formation<Law>& formation;
    Predictor<Law>& predictor;
    Schedule<Law>& schedule;
    Ledger<Law>& ledger;

    // Processes the pending event of body i.
    void process(int i) {
        const PendingEvents& e = paths.pending[i];
        if (e.pair_time <= e.own_time) {
            if (paths.pending[e.partner].count != e.partner_count) return schedule.renew(i);
            const int j = static_cast<int>(e.partner);
            return paths.free(i) && paths.free(j) ? begin_contact(i, j, {}) : resolve_conflict(i, j);
        }
        const SelfEvent own = static_cast<SelfEvent>(e.own);
        if (own == SelfEvent::ends) return formation.end_cluster(paths.pending[i].group);
        if (is_wall(own))
            return meets(i, paths.box.wall(wall_at(own))) ? begin_contact(i, -1, wall_at(own))
                                                          : schedule.renew(i);
        leave_cell(i);
    }
    // Ends an isolated contact: its members get their own radius back. Their paths continue, and their predicted
    // collisions stay valid. Collisions with walls and, in a small box, with other images of the partner must be
    // predicted now.
    void end_isolated_contact(int index) {
        const Group& g = groups[index];
        const IsolatedContact<Law>& l = g.isolated_contact;
        add_to_sums(g);
        const int first = l.body[0], second = l.body[1];
        const auto for_both = [&](const auto& f) {
            f(first);
            if (second >= 0) f(second);
        };
        if constexpr (FrictionalLaw<Law>)
            for (std::size_t m = 0; m < g.body.size(); ++m)
                paths.rotations[static_cast<std::size_t>(g.body[m])].spin = l.surfaces.spin[m];
        for_both([&](int i) { paths.release(i); });
        groups.discard(index);
        if (cells.several_images()) return for_both([&](int i) { schedule.renew(i); });
        if (!paths.box.any_wall()) return;
        for_both([&](int i) {
            predictor.predict_own(i);
            schedule.push(i);
        });
    }

private:
    bool meets(int i, const Wall& wall) const {
        if (!wall.motion.oscillates()) return true;
        const double now = paths.now;
        const auto axis = static_cast<std::size_t>(wall.id.axis());
        return meets_oscillating_wall(wall, now, paths.position(i, now)[axis], paths.velocity(i, now)[axis],
                                      paths.box.gravity[axis], paths.radius(i));
    }
    void leave_cell(int i) {
        const auto crossing = cells.cross(i);
        ledger.sums.shear_work += crossing.shear_work;
        predictor.predict_crossed(i, crossing);
        schedule.push(i);
    }
    // Begins a contact between bodies i and j, or between body i and a wall if j < 0.
    void begin_contact(int i, int j, WallId wall) {
        paths.restart(i);
        if (j >= 0) paths.restart(j);
        ledger.begin_contact(j >= 0);
        int third_body = -1;
        if (try_isolated_contact(i, j, wall, third_body)) return;
        ClusterSeed<Law> seed{{i}, {new_pair<Law>(i, j, wall, paths.now)}};
        seed.pairs[0].pair.state = ContactState::closed;
        seed.pairs[0].pair.fresh = true;
        if constexpr (FrictionalLaw<Law>) seed.pairs[0].pair.surfaces.start = PairSurfaces<Law>::Start::touch;
        if (j >= 0) seed.bodies.push_back(j);
        if (third_body >= 0) formation.absorb(third_body, seed);
        formation.form(seed);
    }
    // Solves a new contact as isolated if, according to the present predictions, no third body disturbs it. Otherwise
    // nothing changes; `third_body` is then the body that is too near, if that is the reason.
    bool try_isolated_contact(int i, int j, WallId wall, int& third_body) {
        const int index = groups.add();
        Group& g = groups[index];
        isolated.open(g, i, j, wall);
        SeparatedMembers after;
        if (!isolated.solve(g, after)) {
            groups.discard(index);
            return false;
        }
        members.follow_outgoing(index, after);
        for (const int k : g.body) {
            predictor.predict_without(k, j < 0 ? k : i + j - k);
            if (paths.pending[k].pair_time > paths.now) continue;
            third_body = static_cast<int>(paths.pending[k].partner);
            members.revert(index);
            return false;
        }
        for (const int k : g.body) schedule.push(k);
        schedule.push_contact_end(i);
        return true;
    }
    // A group continues together with the body that disturbs it.
    void resolve_conflict(int i, int j) {
        ClusterSeed<Law> seed;
        for (const int k : {i, j}) formation.absorb(k, seed);
        formation.form(seed);
    }
    void add_to_sums(const Group& g) {
        const IsolatedContact<Law>& l = g.isolated_contact;
        Observation& sums = ledger.sums;
        ledger.end_contact(g, l.pair, l.contact);
        sums.largest_compression = math::max(sums.largest_compression, g.compression);
        sums.dissipated_energy += l.dissipated;
        if constexpr (FrictionalLaw<Law>) sums.friction_loss += l.surfaces.rubbed;
        sums.virial += l.virial;
        if (const ContactPair<Law>& q = l.pair; q.second < 0) {
            const double impulse = g.wall_impulse, work = q.side * impulse * q.wall_velocity;
            sums.wall_work += work;
            sums.walls.add(q.wall_id, impulse, l.dissipated - work);
        }
        sums.shear_work += frames.shear_work_of_contact(g);
    }
};

}  // namespace hardlimit::boxes::events
