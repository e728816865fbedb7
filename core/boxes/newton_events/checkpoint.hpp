// Checkpoints of the event-driven engine. A loaded run continues bit for bit.
#pragma once
#include "engine.hpp"

namespace hardlimit::boxes {

template <class Law>
template <class Archive>
void NewtonEvents<Law>::exchange(Archive& archive, Cluster<Law>& c) {
    archive(c.members), archive(c.pairs), archive(c.wall_pieces), archive(c.gravity),
        archive(c.largest_coordinate), archive(c.base), archive(c.time);
    archive(c.dissipated), archive(c.virial), archive(c.wall_work), archive(c.shear_work), archive(c.walls),
        archive(c.begun), archive(c.begun_pairs), archive(c.ended), archive(c.unresolved),
        archive(c.too_deep), archive(c.largest_compression);
}

// Everything except the groups. The queues are rebuilt from bodies and groups.
template <class Law>
template <class Archive>
void NewtonEvents<Law>::exchange(Archive& archive) {
    archive(particles_), archive(pending_), archive(free_groups_), archive(log_);
    archive(now_), archive(dissipated_), archive(virial_), archive(wall_work_), archive(shear_work_),
        archive(walls_), archive(clustered_);
    archive(begun_), archive(begun_pairs_), archive(ended_), archive(overlapped_), archive(events_);
    archive(largest_cluster_), archive(integration_steps_), archive(begun_before_), archive(paused_),
        archive(outcome_);
    archive(ended_by_), archive(ended_at_wall_), archive(largest_compression_);
}

template <class Law>
template <class Archive, class T, std::size_t most_in_place>
void NewtonEvents<Law>::exchange(Archive& archive, SmallVector<T, most_in_place>& list) {
    std::vector<T> held(list.begin(), list.end());
    archive(held);
    list.assign(held);
}

template <class Law>
template <class Archive>
void NewtonEvents<Law>::exchange(Archive& archive, Group& g) {
    archive(g.alive), archive(g.isolated), archive(g.compression), archive(g.wall_impulse), archive(g.until);
    archive(g.origin), archive(g.sheared_energy);
    exchange(archive, g.body);
    exchange(archive, g.image_offset);
    if (!g.alive) return;
    if (g.isolated) return archive(g.isolated_contact);
    if (!g.cluster) g.cluster = std::make_unique<ClusterStates>();
    for (Cluster<Law>* c : {&g.cluster->before, &g.cluster->after}) exchange(archive, *c);
}

template <class Law>
std::vector<char> NewtonEvents<Law>::save() const {
    NewtonEvents& self =
        const_cast<NewtonEvents&>(*this);  // exchange() serves reading and writing; a writer only reads
    Writer writer("newton_events");
    self.setting_.exchange(writer);
    writer(largest_safety_radius_), writer(cells_.columns());
    self.exchange(writer);
    writer(groups_.size());
    for (Group& g : self.groups_) exchange(writer, g);
    return writer.finish();
}

template <class Law>
NewtonEvents<Law>::NewtonEvents(const NewtonSetting& setting, Reader& reader,
                                const hardlimit_abi::TouchKernels& kernels)
    : setting_(setting),
      laws_(setting_.laws<Law>()),
      soft_(soft_contacts(laws_, setting_.count(), kernels)),
      gravity_(std::to_array(box_.gravity)) {
    const std::size_t count = setting_.count();
    find_extreme_radii(count);
    reader(largest_safety_radius_);
    make_cells(count, kernels);
    double columns = 0.0;
    reader(columns);
    if (box_.is_sheared()) cells_.set_columns(columns);
    exchange(reader);
    if (reader.failed()) return;
    std::vector<u32> names;
    for (const BodyEvents& e : pending_) names.push_back(e.original_index);
    laws_.reorder(names);
    std::size_t groups = 0;
    reader(groups);
    for (std::size_t i = 0; i < groups && !reader.failed(); ++i) {
        exchange(reader, groups_.emplace_back());
        if (const auto& ends = groups_.back().cluster) ends->before.kernels = ends->after.kernels = series_;
    }
    if (reader.failed()) return;
    put_into_cells();
    restart_calendar_queue();
    for (int i = 0; i < static_cast<int>(count); ++i)
        if (const BodyEvents& e = pending_[i]; e.first && !e.clustered)
            contact_ends_.push(e.end, i, e.group, by_original_index());
}

}  // namespace hardlimit::boxes
