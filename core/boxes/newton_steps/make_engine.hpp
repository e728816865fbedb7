// The engine of small steps for any contact law, behind the interface of all engines.
#pragma once
#include <memory>

#include "../common/newton_setting.hpp"
#include "engine.hpp"

namespace hardlimit::boxes {

template <class Law>
class NewtonStepsEngine final : public Engine {
public:
    NewtonStepsEngine(const NewtonSetting& setting, const System& s)
        : setting_(setting),
          run_(setting.box, setting.in_three(s.position), setting.in_three(s.velocity), setting.laws<Law>(),
               setting.time_step, setting.log) {}
    NewtonStepsEngine(const NewtonSetting& setting, Reader& saved)
        : setting_(setting),
          run_(setting.box, setting.laws<Law>(), setting.count(), setting.time_step, setting.log, saved) {}

    void advance(double until, u64 most_work, int threads, Stop& stop) override {
        constexpr std::chrono::milliseconds between_questions{50};
        run_.advance(until, most_work, threads, between_questions, [&] { return stop.now(); });
    }
    bool paused() const override { return run_.paused(); }
    double time() const override { return run_.time(); }
    Outcome outcome() const override { return run_.outcome(); }
    EarlyEnd early_end() const override { return {run_.time(), run_.ended_by(), {run_.ended_at_wall()}}; }
    u64 work() const override { return run_.steps_taken(); }
    u64 contacts() const override { return run_.log().begun(); }
    u64 logged() const override { return run_.log().ended(); }
    std::vector<Statistic> statistics() const override {
        return {{"time_step", run_.time_step()},
                {"n_steps", static_cast<double>(run_.steps_taken())},
                {"n_lists", static_cast<double>(run_.lists_made())},
                {"skin", run_.skin()}};
    }
    void state(double* position, double* velocity) const override {
        std::vector<double> x(3 * size()), v(3 * size());
        run_.state(x.data(), v.data());
        setting_.from_three(x, position);
        setting_.from_three(v, velocity);
    }
    Observation observe() const override {
        const StepsObservables seen = run_.observe();
        Observation o;
        o.kinetic_energy = seen.kinetic, o.potential_energy = seen.potential, o.contact_energy = seen.contact;
        std::copy_n(seen.momentum, 3, o.momentum);
        o.dissipated_energy = seen.dissipated, o.virial = seen.virial;
        o.largest_compression = run_.largest_compression();
        o.begun = run_.log().begun(), o.pairs = run_.log().pairs(), o.ended = run_.log().ended();
        o.overlapped = run_.log().overlapped(), o.in_contact = seen.in_contact;
        return o;
    }
    bool contacts_last() const override { return true; }
    std::vector<ContactRow> take_log() override { return run_.take_log(); }
    std::vector<ContactRow> open_contacts() const override { return run_.open_contacts(); }
    std::vector<char> save() const override {
        Writer writer("newton_steps");
        NewtonSetting(setting_).exchange(writer);
        const_cast<NewtonSteps<Law>&>(run_).save(writer);
        return writer.finish();
    }
    std::size_t bytes() const override { return sizeof *this; }
    int dimension() const override { return setting_.box.dimension; }
    std::size_t size() const override { return setting_.count(); }

private:
    NewtonSetting setting_;
    NewtonSteps<Law> run_;
};

inline std::unique_ptr<Engine> make_newton_steps(const System& s, const LawChoice& law, bool keep_log,
                                                 double time_step) {
    const NewtonSetting setting(s, law, keep_log, time_step);
    return with_law<std::unique_ptr<Engine>>(law.law, [&]<class Law>() -> std::unique_ptr<Engine> {
        return std::make_unique<NewtonStepsEngine<Law>>(setting, s);
    });
}

// Nothing where the bytes are no whole archive of this engine.
inline std::unique_ptr<Engine> load_newton_steps(const char* data, std::size_t n) {
    Reader reader(data, n);
    if (!reader.whole("newton_steps")) return nullptr;
    NewtonSetting setting;
    setting.exchange(reader);
    auto engine = with_law<std::unique_ptr<Engine>>(
        reader.failed() ? -1 : setting.law.law, [&]<class Law>() -> std::unique_ptr<Engine> {
            return std::make_unique<NewtonStepsEngine<Law>>(setting, reader);
        });
    return reader.failed() ? nullptr : std::move(engine);
}

}  // namespace hardlimit::boxes
