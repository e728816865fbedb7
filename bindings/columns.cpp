// A column under any law.
#define HL_COMMA_COLUMN(name) , col::Column<hl::contact::name>
using AnyColumn = VariantOf<void HARDLIMIT_LAWS(HL_COMMA_COLUMN)>;

struct PyColumn {
    AnyColumn value;
};

PyColumn make_column(bool floor, double gravity, std::vector<double> mass, std::vector<double> radius,
                     const std::vector<Contact>& contacts, std::vector<double> gaps,
                     std::vector<double> velocity) {
    PyColumn made;
    const bool same = std::visit(
        [&](const auto& first) {
            using Law = std::decay_t<decltype(first)>;
            col::Column<Law> c{
                static_cast<int>(mass.size()), floor, gravity, mass, radius, {}, gaps, velocity};
            for (const Contact& k : contacts) {
                const Law* law = std::get_if<Law>(&k.law);
                if (!law) return false;
                c.contacts.push_back(*law);
            }
            made.value = std::move(c);
            return true;
        },
        contacts.front().law);
    if (!same) throw nb::value_error("law: every contact of a column must follow the same kind of law");
    return made;
}

// States at the times asked for.
struct Samples {
    std::size_t n, balls;
    std::vector<double> position, velocity, force, kinetic, potential, stored, dissipated;
    Samples(std::size_t n_, std::size_t balls_)
        : n(n_),
          balls(balls_),
          position(n_ * balls_),
          velocity(n_ * balls_),
          force(n_ * balls_),
          kinetic(n_),
          potential(n_),
          stored(n_),
          dissipated(n_) {}
};

// What every solver returns.
struct Solution {
    col::Sequence sequence;
    std::vector<col::Contact> contacts;
    double t_first = hl::math::nan, t_last = hl::math::nan;  // span that can be sampled
    long steps = 0;
    double energy_error = hl::math::nan;
    virtual ~Solution() = default;
    virtual void sample(const double* times, Samples& out) = 0;
};

struct ExactSolution final : Solution {
    col::LinearColumn column;
    col::Drop drop;
    ExactSolution(const col::LinearColumn& c, col::Coupling coupling, double until)
        : column(c), drop(col::solve_drop(c, coupling, until)) {
        sequence = drop.sequence;
        contacts = drop.contacts;
        steps = static_cast<long>(drop.nodes.size());
        if (drop.nodes.empty()) return;
        t_first = drop.nodes.front().t / drop.start.units.rate;
        t_last = drop.nodes.back().t / drop.start.units.rate;
    }
    void sample(const double* times, Samples& out) override {
        for (std::size_t i = 0; i < out.n; ++i) {
            const col::DropSample s = col::sample_drop(column, drop, times[i]);
            out.position[2 * i] = s.u + column.radius[0];
            out.position[2 * i + 1] = s.u + s.w + 2.0 * column.radius[0] + column.radius[1];
            out.velocity[2 * i] = s.du;
            out.velocity[2 * i + 1] = s.du + s.dw;
            out.force[2 * i] = s.force_floor;
            out.force[2 * i + 1] = s.force_pair;
            out.kinetic[i] = s.kinetic;
            out.potential[i] = s.potential;
            out.stored[i] = s.stored;
            out.dissipated[i] = s.dissipated;
        }
    }
};

template <class Law>
struct IndependentSolution final : Solution {
    col::Column<Law> column;
    col::IndependentRun run;
    double until;
    IndependentSolution(const col::Column<Law>& c, double until_)
        : column(c), run(col::solve_independent(c, until_)), until(until_) {
        sequence = run.sequence;
        contacts = run.contacts;
        steps = static_cast<long>(run.flights.size());
        t_first = run.flights.front().t;
        t_last = hl::math::is_nan(until) ? run.flights.back().t : hl::math::max(until, run.flights.back().t);
    }
    double mechanical(const col::Flight& f, Samples* out, std::size_t i) const {
        double kinetic = 0.0, potential = 0.0, height = 0.0, position = f.lowest;
        for (int j = 0; j < column.balls; ++j) {
            if (j > 0) position += column.radius[j - 1] + f.gaps[j] + column.radius[j];
            kinetic += 0.5 * column.mass[j] * f.velocity[j] * f.velocity[j];
            height += f.gaps[j];
            potential += column.gravity * column.mass[j] * height;
            if (out) {
                out->position[i * out->balls + j] = position;
                out->velocity[i * out->balls + j] = f.velocity[j];
            }
        }
        if (out) {
            out->kinetic[i] = kinetic;
            out->potential[i] = potential;
        }
        return kinetic + potential;
    }
    void sample(const double* times, Samples& out) override {
        const double initial = mechanical(run.flights.front(), nullptr, 0);
        for (std::size_t i = 0; i < out.n; ++i) {
            std::size_t k = 0;
            while (k + 1 < run.flights.size() && run.flights[k + 1].t <= times[i]) ++k;
            col::Flight f = run.flights[k];
            col::independent::advance(column, f, times[i] - f.t);
            out.dissipated[i] = initial - mechanical(f, &out, i);
        }
    }
};

template <class Law>
struct IntegratedSolution final : Solution {
    col::Column<Law> column;
    col::Integration<Law> run;
    IntegratedSolution(const col::Column<Law>& c, double until, double tolerance) : column(c) {
        col::IntegrateOptions options;
        options.tolerance = tolerance;
        options.until = until;
        options.record = true;
        run = col::integrate(c, options);
        sequence = run.sequence;
        contacts = run.contacts;
        steps = run.steps;
        energy_error = run.energy_error;
        if (run.intervals.empty()) return;
        t_first = run.intervals.front().t;
        t_last = run.intervals.back().t;
    }
    void sample(const double* times, Samples& out) override {
        std::vector<double> gaps(out.n * out.balls);
        std::vector<col::Energies> energies(out.n);
        col::sample(column, run, times, static_cast<long>(out.n),
                    col::Samples{gaps.data(), out.velocity.data(), out.force.data(), energies.data()});
        for (std::size_t i = 0; i < out.n; ++i) {
            double z = 0.0;
            for (std::size_t j = 0; j < out.balls; ++j) {
                z += gaps[i * out.balls + j] + column.radius[j] + (j > 0 ? column.radius[j - 1] : 0.0);
                out.position[i * out.balls + j] = z;
            }
            out.kinetic[i] = energies[i].kinetic;
            out.potential[i] = energies[i].potential;
            out.stored[i] = energies[i].contact;
            out.dissipated[i] = energies[i].dissipated;
        }
    }
};

std::unique_ptr<Solution> newton(const PyColumn& c, double until, bool general, double tolerance) {
    nb::gil_scoped_release unlocked;
    return std::visit(
        [&](const auto& column) -> std::unique_ptr<Solution> {
            using Law = std::decay_t<decltype(column.contacts[0])>;
            if constexpr (std::is_same_v<Law, hl::contact::LinearDashpot>)
                if (!general && column.floor && column.balls == 2)
                    return std::make_unique<ExactSolution>(column, col::Coupling::full, until);
            return std::make_unique<IntegratedSolution<Law>>(column, until, tolerance);
        },
        c.value);
}

std::unique_ptr<Solution> adiabatic(const PyColumn& c, double until) {
    const auto* linear = std::get_if<col::LinearColumn>(&c.value);
    if (!linear || !linear->floor || linear->balls != 2)
        throw nb::value_error(
            "column: the adiabatic solution is that of two balls on a floor under the linear law");
    nb::gil_scoped_release unlocked;
    return std::make_unique<ExactSolution>(*linear, col::Coupling::adiabatic, until);
}

std::unique_ptr<Solution> independent(const PyColumn& c, double until) {
    nb::gil_scoped_release unlocked;
    return std::visit(
        [&](const auto& column) -> std::unique_ptr<Solution> {
            using Law = std::decay_t<decltype(column.contacts[0])>;
            return std::make_unique<IndependentSolution<Law>>(column, until);
        },
        c.value);
}

auto contact_arrays(const Solution& s) {
    const std::size_t n = s.contacts.size();
    std::vector<int> pair(n);
    std::vector<double> begin(n), end(n);
    for (std::size_t i = 0; i < n; ++i) {
        pair[i] = s.contacts[i].pair;
        begin[i] = s.contacts[i].begin;
        end[i] = s.contacts[i].end;
    }
    return std::tuple(make_array(std::move(pair), {n}), make_array(std::move(begin), {n}),
                      make_array(std::move(end), {n}));
}

auto sample(Solution& s, In times, std::size_t balls) {
    Samples out(times.shape(0), balls);
    {
        nb::gil_scoped_release unlocked;
        s.sample(times.data(), out);
    }
    const std::size_t n = out.n;
    return std::tuple(make_array(std::move(out.position), {n, balls}),
                      make_array(std::move(out.velocity), {n, balls}),
                      make_array(std::move(out.force), {n, balls}), make_array(std::move(out.kinetic), {n}),
                      make_array(std::move(out.potential), {n}), make_array(std::move(out.stored), {n}),
                      make_array(std::move(out.dissipated), {n}));
}

void bind_columns(nb::module_& m) {
    nb::class_<PyColumn>(m, "Column", "A column of balls in SI units.");
    m.def("make_column", &make_column, "floor"_a, "gravity"_a, "mass"_a, "radius"_a, "contacts"_a, "gaps"_a,
          "velocity"_a);
    nb::class_<Solution>(m, "Solution", "What a solver found.")
        .def_prop_ro("n_contacts", [](const Solution& s) { return s.sequence.n_contacts; })
        .def_prop_ro("t_end", [](const Solution& s) { return s.sequence.t_end; })
        .def_prop_ro("t_floor_end", [](const Solution& s) { return s.sequence.t_floor_end; })
        .def_prop_ro("relative_velocity", [](const Solution& s) { return s.sequence.relative_velocity; })
        .def_prop_ro("separation_velocity", [](const Solution& s) { return s.sequence.separation_velocity; })
        .def_prop_ro("outcome", [](const Solution& s) { return static_cast<int>(s.sequence.outcome); })
        .def_ro("t_first", &Solution::t_first)
        .def_ro("t_last", &Solution::t_last)
        .def_ro("steps", &Solution::steps)
        .def_ro("energy_error", &Solution::energy_error)
        .def("contacts", &contact_arrays)
        .def("sample", &sample, "times"_a, "balls"_a);
    m.def("newton", &newton, "column"_a, "until"_a, "general"_a, "tolerance"_a);
    m.def("adiabatic", &adiabatic, "column"_a, "until"_a);
    m.def("independent", &independent, "column"_a, "until"_a);
    m.def("fall_time", &col::fall_time, "gap"_a, "velocity"_a, "gravity"_a);
    m.def("impact_speed", &col::impact_speed, "gap"_a, "velocity"_a, "gravity"_a);
    m.def("effective_restitution", &col::effective_restitution<double>, "relative_velocity"_a,
          "impact_speed"_a);
}

}  // namespace

void bind_sweep(nb::module_& m);

NB_MODULE(_core, m) {
    nb::set_leak_warnings(false);  // objects alive at exit, in a traceback say, are no fault
    m.attr("version") = HARDLIMIT_VERSION;
    nb::list names, messages;
    for (const hl::OutcomeRecord& r : hl::outcome_records) {
        names.append(r.name);
        messages.append(r.message);
    }
    m.attr("outcome_names") = nb::tuple(names);
    m.attr("outcome_messages") = nb::tuple(messages);
    bind_contacts(m);
    bind_math(m);
    bind_columns(m);
    bind_sweep(m);
}
