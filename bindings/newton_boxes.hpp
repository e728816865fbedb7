// What the bindings of the two engines for Newton's equations in a box share: arrays in and out, the law, saved states.
#pragma once
#include <nanobind/stl/string.h>
#include <nanobind/stl/tuple.h>
#include <nanobind/stl/vector.h>

#include <memory>
#include <string>
#include <tuple>
#include <utility>
#include <vector>

#include "arrays.hpp"
#include "boxes/common/archive.hpp"
#include "boxes/common/bodies.hpp"
#include "boxes/common/contact_record.hpp"
#include "boxes/common/pair_laws.hpp"
#include "contact.hpp"
#include "early_end.hpp"

namespace hardlimit::bindings {

using Table = nanobind::ndarray<const double, nanobind::ndim<2>, nanobind::c_contig, nanobind::device::cpu>;
using Numbers = std::vector<double>;
// A law as (name, alternative, parameters), as make_contact takes it.
using LawChoice = std::tuple<std::string, int, Numbers>;

inline void require(bool met, const char* what) {
    if (!met) throw nanobind::value_error(what);
}

inline std::vector<char> letters(const std::string& text) { return {text.begin(), text.end()}; }
inline std::string name_in(const std::vector<char>& letters) { return {letters.begin(), letters.end()}; }

// What a run is made of, beside the state.
struct BoxSetting {
    boxes::Box3 box{};
    Numbers mass, radius;   // [N]
    std::vector<char> law;  // its name
    int alternative = 0;
    Numbers parameters;
    bool log = false;

    BoxSetting() = default;
    BoxSetting(Table positions, Table velocities, In radii, In masses, const Numbers& edges,
               const std::vector<bool>& periodic, const Numbers& gravity, const LawChoice& choice,
               bool keep_log)
        : mass(masses.data(), masses.data() + masses.shape(0)),
          radius(radii.data(), radii.data() + radii.shape(0)),
          law(letters(std::get<0>(choice))),
          alternative(std::get<1>(choice)),
          parameters(std::get<2>(choice)),
          log(keep_log) {
        const std::size_t n = positions.shape(0), d = positions.shape(1);
        require(n > 0 && n < (std::size_t{1} << 27), "positions: must be 1 to 2^27 - 1 bodies");
        require(d == 2 || d == 3, "positions: must have two or three columns");
        require(velocities.shape(0) == n && velocities.shape(1) == d,
                "velocities: must have the shape of positions");
        require(radius.size() == n && mass.size() == n, "radius | mass: must be one number for each body");
        require(edges.size() == d && periodic.size() == d && gravity.size() == d,
                "box | periodic | gravity: must be one for each axis");
        box.dimension = static_cast<int>(d);
        for (std::size_t axis = 0; axis < d; ++axis) {
            box.edge[axis] = edges[axis];
            box.periodic[axis] = periodic[axis];
            box.gravity[axis] = gravity[axis];
        }
    }

    template <class Archive>
    void exchange(Archive& archive) {
        archive(box), archive(mass), archive(radius), archive(law), archive(alternative), archive(parameters);
        archive(log);
    }

    template <class Law>
    boxes::PairLaws<Law> laws() const {
        const LawRecord& record = Law::record;
        require(alternative >= 0 && alternative < record.n_alternatives,
                "alternative: the law has no such set of parameters");
        const int wanted = record.n_common + record.n_in_alternative[alternative];
        require(parameters.size() == static_cast<std::size_t>(wanted), "parameters: wrong number of values");
        return {alternative, parameters, mass, radius};
    }
};

// visit.operator()<Law>() for the law of this name.
template <class Visit>
auto with_law(const std::string& name, const Visit& visit) {
#define HL_LAW(Law) \
    if (name == contact::Law::record.name) return visit.template operator()<contact::Law>();
    HARDLIMIT_LAWS(HL_LAW)
#undef HL_LAW
    throw nanobind::value_error(("law: unknown name " + name).c_str());
}

// A run as bytes: what marks it as one of this engine, what it is made of, the state.
template <class Setting, class Engine>
nanobind::bytes saved(const char* mark, Setting setting, Engine& engine) {
    boxes::Writer writer;
    writer(letters(mark));
    setting.exchange(writer);
    engine.save(writer);
    const std::vector<char> bytes = writer.finish();
    return nanobind::bytes(bytes.data(), bytes.size());
}

// The other way: `setting` is read, make(reader) makes the engine from it and from what follows.
template <class Setting, class Make>
auto loaded(const char* mark, const nanobind::bytes& state, Setting& setting, const Make& make) {
    boxes::Reader reader(state.c_str(), state.size());
    require(reader.whole(), "state: not a saved run, or damaged");
    std::vector<char> found;
    reader(found);
    require(name_in(found) == mark, "state: not of a run by this engine of this version");
    setting.exchange(reader);
    auto engine = make(reader);
    require(!reader.failed(), "state: damaged");
    return engine;
}

// [N, d] as [3 N], with zeros where there is no third axis; and back.
inline Numbers in_three(Table table) {
    const std::size_t n = table.shape(0), d = table.shape(1);
    Numbers out(3 * n, 0.0);
    for (std::size_t i = 0; i < n; ++i)
        std::copy_n(table.data() + d * i, d, out.begin() + static_cast<long>(3 * i));
    return out;
}
inline auto rows(const Numbers& three, int dimension) {
    const auto d = static_cast<std::size_t>(dimension);
    Numbers out;
    for (std::size_t at = 0; at < three.size(); at += 3)
        out.insert(out.end(), three.begin() + static_cast<long>(at),
                   three.begin() + static_cast<long>(at + d));
    return make_array(std::move(out), {three.size() / 3, d});
}

// From an engine of any law.
template <class Engine>
EarlyEnd early_end(const Engine& engine) {
    if (engine.outcome() == Outcome::ok) return {};
    const i64 wall = engine.ended_at_wall();
    return std::tuple(engine.time(), engine.ended_by(), wall < 0 ? std::optional(wall) : std::nullopt);
}

// Contacts as begin, end, first, second, impact_speed, separation_speed, overlapped.
inline nanobind::tuple columns(const std::vector<boxes::ContactRecord>& rows) {
    const std::size_t n = rows.size();
    Numbers begin, end, impact, separation;
    std::vector<std::int64_t> first, second;
    std::vector<std::uint8_t> overlapped;
    for (const boxes::ContactRecord& r : rows) {
        begin.push_back(r.begin), end.push_back(r.end);
        first.push_back(r.first), second.push_back(r.second);
        impact.push_back(r.impact_speed), separation.push_back(r.separation_speed);
        overlapped.push_back(r.overlapped);
    }
    return nanobind::make_tuple(make_array(std::move(begin), {n}), make_array(std::move(end), {n}),
                                make_array(std::move(first), {n}), make_array(std::move(second), {n}),
                                make_array(std::move(impact), {n}), make_array(std::move(separation), {n}),
                                make_array(std::move(overlapped), {n}));
}

}  // namespace hardlimit::bindings
