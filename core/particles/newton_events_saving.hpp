// The state of a run as bytes and back: it goes on with the same bits.
#pragma once
#include "newton_events.hpp"

namespace hardlimit::particles {

template <class Law>
template <class Archive>
void NewtonEvents<Law>::exchange(Archive& archive, Cluster<Law>& c) {
    archive(c.members), archive(c.pairs), archive(c.gravity), archive(c.base), archive(c.time);
    archive(c.dissipated), archive(c.virial), archive(c.begun), archive(c.begun_pairs), archive(c.ended),
        archive(c.unresolved);
}

// All but the groups; the queue follows from what the bodies and groups hold.
template <class Law>
template <class Archive>
void NewtonEvents<Law>::exchange(Archive& archive) {
    archive(bodies_), archive(spare_), archive(head_), archive(log_);
    archive(now_), archive(dissipated_), archive(virial_), archive(clustered_);
    archive(begun_), archive(begun_pairs_), archive(ended_), archive(overlapped_), archive(events_);
    archive(largest_cluster_), archive(paused_), archive(outcome_);
}

template <class Law>
void NewtonEvents<Law>::save(Writer& writer) const {
    NewtonEvents& self =
        const_cast<NewtonEvents&>(*this);  // exchange reads and writes with one list; a writer reads
    self.exchange(writer);
    writer(groups_.size());
    for (Group& g : self.groups_) {
        writer(g.alive), writer(g.isolated), writer(g.serial), writer(g.origin), writer(g.body),
            writer(g.offset);
        writer(g.lone);
        exchange(writer, g.before);
        exchange(writer, g.after);
    }
}

template <class Law>
NewtonEvents<Law>::NewtonEvents(const Box& box, PairLaws<Law> laws, std::size_t count, bool log,
                                Reader& reader)
    : box_(box),
      laws_(std::move(laws)),
      soft_(soft_contacts(laws_, count)),
      keep_log_(log),
      gravity_(std::to_array(box.gravity)) {
    for (std::size_t i = 0; i < count; ++i) {
        largest_ = math::max(largest_, laws_.radius(i));
        smallest_ = math::min(smallest_, laws_.radius(i));
    }
    make_cells();
    exchange(reader);
    std::size_t groups = 0;
    reader(groups);
    for (std::size_t i = 0; i < groups && !reader.failed(); ++i) {
        Group& g = groups_.emplace_back();
        reader(g.alive), reader(g.isolated), reader(g.serial), reader(g.origin), reader(g.body),
            reader(g.offset);
        reader(g.lone);
        exchange(reader, g.before);
        exchange(reader, g.after);
    }
    for (std::size_t i = 0; i < bodies_.size(); ++i)
        queue_.push({bodies_[i].when, static_cast<int>(i), bodies_[i].event});
    for (std::size_t i = 0; i < groups_.size(); ++i) {
        const Group& g = groups_[i];
        if (!g.alive) continue;
        const double end = g.isolated ? g.lone.contact.begin + g.lone.span : g.before.base + g.after.time;
        queue_.push({end, ~static_cast<int>(i), g.serial});
    }
}

}  // namespace hardlimit::particles
