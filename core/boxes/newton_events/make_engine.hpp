// The event-driven engine of Newton's equations for any contact law, behind the interface of all engines.
#pragma once
#include <memory>

#include "../common/newton_setting.hpp"
#include "engine.hpp"

namespace hardlimit::boxes {

// [N d] as [3 N], with zeros where there is no third axis; and back.
inline std::vector<double> to_three(const NewtonSetting& setting, const double* values) {
    std::vector<double> three;
    for (std::size_t i = 0; i < setting.count(); ++i)
        for (const double x : setting.in_three(values, i)) three.push_back(x);
    return three;
}
inline void from_three(const NewtonSetting& setting, const std::vector<double>& three, double* values) {
    const std::size_t d = setting.axes();
    for (std::size_t i = 0; i < setting.count(); ++i) std::copy_n(&three[3 * i], d, values + d * i);
}

template <class Law>
class NewtonEventsEngine final : public Engine {
public:
    NewtonEventsEngine(const NewtonSetting& setting, const System& s,
                       const hardlimit_abi::TouchKernels& kernels)
        : setting_(setting),
          run_(setting.box, to_three(setting, s.position), to_three(setting, s.velocity), setting.laws<Law>(),
               setting.log, kernels) {}
    NewtonEventsEngine(const NewtonSetting& setting, Reader& saved,
                       const hardlimit_abi::TouchKernels& kernels)
        : setting_(setting),
          run_(setting.box, setting.laws<Law>(), setting.count(), setting.log, kernels, saved) {}

    void advance(double until, u64 most_work, int /*threads*/, Stop& stop) override {
        run_.advance(until, most_work, stop);
    }
    bool paused() const override { return run_.paused(); }
    double time() const override { return run_.time(); }
    Outcome outcome() const override { return run_.outcome(); }
    EarlyEnd early_end() const override {
        return {run_.time(), run_.ended_by(), WallId::of(run_.ended_at_wall())};
    }
    u64 work() const override { return run_.events(); }
    u64 contacts() const override { return run_.contacts_reached(); }
    u64 logged() const override { return run_.contacts_logged(); }
    std::vector<Statistic> statistics() const override {
        return {{"n_events", static_cast<double>(run_.events())},
                {"largest_cluster", static_cast<double>(run_.largest_cluster())},
                {"cluster_share", run_.cluster_share()}};
    }
    void state(double* position, double* velocity) const override {
        const auto seen = run_.survey();
        from_three(setting_, seen.position, position);
        from_three(setting_, seen.velocity, velocity);
    }
    Observation observe() const override {
        const auto seen = run_.survey();
        Observation o;
        o.kinetic_energy = seen.kinetic, o.potential_energy = seen.potential, o.contact_energy = seen.contact;
        std::copy_n(seen.momentum, 3, o.momentum);
        o.dissipated_energy = seen.dissipated, o.virial = seen.virial;
        o.largest_compression = seen.largest_compression;
        o.begun = seen.begun, o.pairs = seen.begun_pairs, o.ended = seen.ended;
        o.overlapped = seen.overlapped, o.in_contact = seen.in_contact;
        return o;
    }
    bool contacts_last() const override { return true; }
    std::vector<ContactRecord> take_log() override { return run_.take_log(); }
    std::vector<ContactRecord> open_contacts() const override { return run_.survey().open; }
    double safety_used(int instants) const override { return run_.margin_used(instants); }
    std::vector<char> save() const override {
        Writer writer("newton_events");
        NewtonSetting(setting_).exchange(writer);
        run_.save(writer);
        return writer.finish();
    }
    std::size_t bytes() const override { return sizeof *this; }
    int dimension() const override { return setting_.box.dimension; }
    std::size_t size() const override { return setting_.count(); }

private:
    NewtonSetting setting_;
    NewtonEvents<Law> run_;
};

inline std::unique_ptr<Engine> make_newton_events(const System& s, const LawChoice& law, bool keep_log,
                                                  const hardlimit_abi::TouchKernels& kernels) {
    const NewtonSetting setting(s, law, keep_log);
    return with_law<std::unique_ptr<Engine>>(law.law, [&]<class Law>() -> std::unique_ptr<Engine> {
        return std::make_unique<NewtonEventsEngine<Law>>(setting, s, kernels);
    });
}

// Nothing where the bytes are no whole archive of this engine.
inline std::unique_ptr<Engine> load_newton_events(const char* data, std::size_t n,
                                                  const hardlimit_abi::TouchKernels& kernels) {
    Reader reader(data, n);
    if (!reader.whole("newton_events")) return nullptr;
    NewtonSetting setting;
    setting.exchange(reader);
    auto engine = with_law<std::unique_ptr<Engine>>(
        reader.failed() ? -1 : setting.law.law, [&]<class Law>() -> std::unique_ptr<Engine> {
            return std::make_unique<NewtonEventsEngine<Law>>(setting, reader, kernels);
        });
    return reader.failed() ? nullptr : std::move(engine);
}

}  // namespace hardlimit::boxes
