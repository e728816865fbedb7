// Event-driven solution of Newton's equations for a box of spheres or disks under a contact law.
//
// Between contacts the bodies move on parabolas, known exactly. Bodies in contact form a group, which is solved in
// advance from its begin to its end. A contact that no third body disturbs is solved as a whole in the plane of its
// approach (isolated_contacts.hpp). Contacts that share a body form a cluster, which is integrated (cluster/) until its
// contacts are over, or for a limited time.
//
// Until its group ends, a member is busy. For all other bodies it is a larger body on a parabola (membership.hpp). As
// long as no other body touches this larger body, nothing can act on the group, and its solution holds. If one does (a
// conflict), the group is integrated again up to the present, and continues together with that body. So no contact is
// missed, and the solution never contains anything that a later event could change.
//
// Bodies are stored and scheduled like hard spheres (hard_spheres/): sorted by cell, with a record, two pending events
// and a cell for each.
//
// Each part knows only those before it:
//   Paths, BodyCells                        the bodies and where they are
//   Groups, Frames                          records of the bodies in contact, and the frame in which they are solved
//   Ledger                                  what has been added up and logged
//   BusyBodies, Predictor, Schedule         what comes next
//   IsolatedContacts, Clusters, Membership  groups are solved in advance; bodies enter and leave them
//   Formation, ContactEvents                what happens at an event
//   Observer                                state and sums at the current time
#pragma once
#include <cstddef>
#include <memory>
#include <utility>
#include <vector>

#include "checkpoint.hpp"
#include "events.hpp"
#include "make_engine.hpp"
#include "observe.hpp"
#include "safety_use.hpp"
#include "start.hpp"

namespace hardlimit::boxes {

template <class Law>
class NewtonEvents final : public Engine {
public:
    // Bodies that overlap start in contact if their force is repulsive.
    NewtonEvents(const NewtonSetting& setting, const System& s, const hardlimit_abi::TouchKernels& kernels)
        : NewtonEvents(setting, events::initial_safety_radius<Law>(setting, s), kernels) {
        cells_.sort_in(setting_, s);
        const std::vector<int> touching = predictor_.predict_first(limits_.largest_radius);
        events::InitialContacts<Law> contacts{paths_, cells_, ledger_};
        contacts.find(touching);
        formation_.form_parts(contacts.bodies, contacts.pairs);
        if (contacts.pairs.empty())
            for (const int i : touching) predictor_.predict(i);
        else
            for (int i = 0; i < paths_.size(); ++i)
                if (paths_.free(i)) predictor_.predict(i);
        schedule_.rebuild();
    }
    // Continues a saved run.
    NewtonEvents(const NewtonSetting& setting, Reader& reader, const hardlimit_abi::TouchKernels& kernels)
        : NewtonEvents(setting, read_number(reader), kernels) {
        cells_.set_columns(read_number(reader));
        exchange(reader);
        if (reader.failed()) return;
        paths_.sort_properties();
        std::size_t count = 0;
        reader(count);
        for (std::size_t k = 0; k < count && !reader.failed(); ++k) {
            auto& g = groups_.records().emplace_back();
            events::exchange(reader, g);
            if (g.cluster) clusters_.attach_kernels(*g.cluster);
        }
        if (reader.failed()) return;
        cells_.put_in();
        schedule_.rebuild();
        for (int i = 0; i < paths_.size(); ++i)
            if (paths_.pending[i].first && !paths_.clustered(i)) schedule_.push_contact_end(i);
    }

    // The unit of work is an event.
    void advance(double until, u64 most_work, int /*threads*/, Stop& stop) override {
        const u64 last = most_work > ~events_ ? ~u64{0} : events_ + most_work;
        paused_ = false;
        observer_.forget();
        while (outcome() == Outcome::ok) {
            const auto due = schedule_.next();
            const bool tilts = due.time > cells_.next_tilt();
            const double time = tilts ? cells_.next_tilt() : due.time;
            if (time > until || time == math::infinity) break;
            if (events_ >= last || (tilts ? stop.now() : stop())) {
                paused_ = true;
                return;
            }
            paths_.now = math::max(paths_.now, time);
            if (tilts) {
                tilt_cells();
                continue;
            }
            ++events_;
            schedule_.pop(due);
            if (due.group >= 0)
                contact_events_.end_isolated_contact(due.group);
            else
                contact_events_.process(due.body);
        }
        if (outcome() == Outcome::ok) paths_.now = math::max(paths_.now, until);
    }
    bool paused() const override { return paused_; }
    double time() const override { return paths_.now; }
    Outcome outcome() const override { return ledger_.outcome; }
    EarlyEnd early_end() const override { return {paths_.now, ledger_.ended_by, ledger_.ended_at}; }
    u64 work() const override { return events_; }
    // Without contacts that begin or end within an unfinished group.
    u64 contacts() const override { return ledger_.sums.begun; }
    u64 logged() const override { return ledger_.sums.ended; }
    // cluster_share: fraction of the bodies' time spent in clusters.
    std::vector<Statistic> statistics() const override {
        const double time = paths_.now * static_cast<double>(size());
        return {{"n_events", static_cast<double>(events_)},
                {"largest_cluster", static_cast<double>(ledger_.largest_cluster)},
                {"cluster_share", paths_.now > 0.0 ? ledger_.clustered / time : 0.0}};
    }

    // All groups are integrated up to now and formed again from the contacts that are open.
    double set_velocities(const double* velocity, const double* spin) override {
        observer_.forget();
        formation_.interrupt([&] {
            ledger_.sums.shear_work += paths_.set_velocities(velocity);
            if (spin) paths_.set_spins(spin);
        });
        return 0.0;
    }
    bool rotates() const override { return FrictionalLaw<Law>; }
    void spins(double* spin) const override {
        if constexpr (FrictionalLaw<Law>) observer_.spins(spin);
    }

    // Const: groups are integrated in a copy.
    void state(double* position, double* velocity) const override { observer_.state(position, velocity); }
    Observation observe() const override { return observer_.observe(); }
    bool contacts_have_duration() const override { return true; }
    std::vector<ContactRecord> take_log() override { return std::exchange(ledger_.rows, {}); }
    std::vector<ContactRecord> open_contacts() const override {
        return observer_.groups_at_present(true).open;
    }
    double largest_safety_use(int instants) const override {
        return events::SafetyUse<Law>{paths_, groups_, frames_, clusters_, busy_}.largest(instants);
    }

    std::vector<char> save() const override {
        NewtonEvents& self = const_cast<NewtonEvents&>(*this);  // exchange() serves reading and writing
        Writer writer("newton_events");
        self.setting_.exchange(writer);
        writer(limits_.largest_safety_radius), writer(cells_.columns());
        self.exchange(writer);
        writer(groups_.records().size());
        for (auto& g : self.groups_.records()) events::exchange(writer, g);
        return writer.finish();
    }
    std::size_t bytes() const override {
        return sizeof *this + paths_.bytes() + groups_.bytes() + cells_.bytes() + predictor_.bytes() +
               schedule_.bytes();
    }
    int dimension() const override { return setting_.box.dimension; }
    std::size_t size() const override { return paths_.particles.size(); }

private:
    NewtonSetting setting_;
    events::Limits limits_;
    events::Paths<Law> paths_{setting_};
    events::BodyCells<Law> cells_{setting_, limits_.shortest_cell(), paths_};
    events::Groups<Law> groups_{setting_.count()};
    events::Frames<Law> frames_{paths_};
    events::Ledger<Law> ledger_{paths_, setting_.log};
    events::BusyBodies<Law> busy_{paths_, groups_, cells_.several_images()};
    events::Predictor<Law> predictor_;
    events::Schedule<Law> schedule_{paths_, cells_, groups_, predictor_};
    events::IsolatedContacts<Law> isolated_;
    events::Clusters<Law> clusters_;
    events::Membership<Law> members_{limits_, paths_, groups_, frames_, clusters_, ledger_};
    events::Formation<Law> formation_{paths_,   cells_,     groups_,   clusters_,
                                      members_, predictor_, schedule_, ledger_};
    events::ContactEvents<Law> contact_events_{paths_,   cells_,     groups_,    frames_,   isolated_,
                                               members_, formation_, predictor_, schedule_, ledger_};
    events::Observer<Law> observer_;
    u64 events_ = 0;
    bool paused_ = false;

    NewtonEvents(const NewtonSetting& setting, double safety_radius,
                 const hardlimit_abi::TouchKernels& kernels)
        : setting_(setting),
          limits_(setting_, safety_radius),
          predictor_(paths_, cells_, busy_, kernels),
          isolated_(setting_.count(), limits_, paths_, frames_, kernels),
          clusters_{paths_, frames_, {paths_, limits_.largest_displacement}, ledger_.sums, kernels.series},
          observer_{paths_, groups_, frames_, clusters_, ledger_, kernels.samples} {}

    static double read_number(Reader& reader) {
        double number = 0.0;
        reader(number);
        return number;
    }
    template <class Archive>
    void exchange(Archive& archive) {
        events::exchange(archive, paths_, groups_, ledger_, formation_.budget, events_, paused_);
    }
    // In a sheared box all bodies get new cells, and all events are predicted again.
    void tilt_cells() {
        cells_.tilt_back();
        for (int i = 0; i < paths_.size(); ++i) predictor_.predict(i);
        schedule_.rebuild();
    }
};

template <class Law, class Source>
std::unique_ptr<Engine> newton_events_of(const NewtonSetting& setting, Source& source,
                                         const hardlimit_abi::TouchKernels& kernels) {
    return std::make_unique<NewtonEvents<Law>>(setting, source, kernels);
}

}  // namespace hardlimit::boxes
