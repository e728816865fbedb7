// Generates a small random box for a fuzz target: particles on or near lattice sites, which may touch but do not
// overlap. Frequent special cases: no free space, mirror-symmetric motion, and speeds so small that their squares
// underflow.
#pragma once
#include <algorithm>
#include <type_traits>
#include <vector>

#include "boxes/common/law_choice.hpp"
#include "boxes/common/system_check.hpp"
#include "boxes/kernels/kernel_table.hpp"
#include "check.hpp"

namespace hardlimit::fuzz {

template <int lanes>
constexpr hardlimit_abi::TouchKernels kernels = boxes::touch_kernels<typename Vector<lanes>::Real>("fuzz");

// μ, model, limit and k_t of a law of this kind; 0.0 or more of the damping of the normal force.
template <class Source>
Friction some_friction(Draw<Source>& draw, bool linear) {
    Friction f;
    f.coefficient = draw.often({math::infinity, 1.0, 0.5}, [&] { return draw.decades(1e-4, 10.0); });
    f.limit = draw.below(2) == 0 ? SlipLimit::total : SlipLimit::spring;
    f.damping_ratio = draw.often({0.0, 0.0, 1.0}, [&] { return draw.decades(1e-3, 2.0); });
    if (draw.below(8) == 0) {
        f.model = FrictionModel::none;
        return f;
    }
    f.model = linear ? FrictionModel::spring : static_cast<FrictionModel>(1 + draw.below(4));
    f.stiffness_ratio = draw.often({2.0 / 7.0, 1.0, 0.5}, [&] { return draw.decades(0.05, 2.0); });
    return f;
}

// LawChoice for a law with these parameters.
template <class Law>
boxes::LawChoice law_choice(const Material<Law>& material) {
    boxes::LawChoice choice;
    int place = 0;
#define HL_PLACE(Other)                                          \
    if (std::is_same_v<Law, contact::Other>) choice.law = place; \
    ++place;
    HARDLIMIT_LAWS(HL_PLACE)
#undef HL_PLACE
    choice.alternative = material.alternative;
    const int n = Law::record.n_common + Law::record.n_in_alternative[material.alternative];
    std::copy_n(material.parameters, n, choice.parameters);
    return choice;
}

struct SmallBox {
    boxes::System s{};
    std::vector<double> position, velocity, radius, mass;
    std::vector<double> spin, inertia;  // of add_spins: [3 N], [N] q of the moments of inertia
    double large, speed;                // upper bounds on radii [m] and velocity components [m/s]

    // most_places: largest number of lattice sites along an axis. least_edge: smallest periodic edge, in largest radii.
    template <class Source>
    // sheared: whether an axis may have a Lees–Edwards boundary.
    SmallBox(Draw<Source>& draw, int most_places, double least_edge, bool sheared = false) {
        s.box.dimension = 2 + draw.below(2);
        wide = draw.below(2) != 0;
        large = draw.decades(1e-4, 1.0);
        const double ratio = draw.often({1.0}, [&] { return draw.decades(0.01, 1.0); });
        const double spacing = 2.0 * large * draw.often({1.0}, [&] { return 1.0 + draw.decades(1e-9, 3.0); });
        speed = draw.decades(1e-3, 10.0);
        if (draw.below(4) == 0) {  // common velocity, except for the fraction `apart`
            apart = draw.decades(1e-6, 1.0);
            for (double& x : together) x = (1.0 - apart) * draw.between(-speed, speed);
        }
        mirrored = draw.below(8) == 0;
        slow = draw.below(4) == 0;
        int places[3] = {1, 1, 1};
        for (int k = 0; k < s.box.dimension; ++k) {
            places[k] = 1 + draw.below(most_places);
            s.box.edge[k] = spacing * places[k];
            s.box.boundary[k] = draw.below(2) == 0 ? boxes::Boundary::periodic : boxes::Boundary::wall;
            if (s.box.is_periodic(k)) s.box.edge[k] = math::max(s.box.edge[k], least_edge * large);
            s.box.gravity[k] = draw.often({0.0}, [&] { return draw.between(-10.0, 10.0); });
            if (slow) s.box.gravity[k] *= draw.often({1.0, 0.0}, [&] { return draw.decades(1e-320, 1.0); });
        }
        if (sheared && draw.below(2) == 0) shear(draw);
        for (int x = 0; x < places[0]; ++x)
            for (int y = 0; y < places[1]; ++y)
                for (int z = 0; z < places[2]; ++z) {
                    if (draw.below(4) == 0 && s.n > 0) continue;
                    const int at[3] = {x, y, z};
                    add(draw, at, spacing, draw.below(2) == 0 ? large : ratio * large);
                }
        s.position = position.data(), s.velocity = velocity.data();
        s.radius = radius.data(), s.mass = mass.data();
    }
    SmallBox(const SmallBox&) = delete;
    SmallBox& operator=(const SmallBox&) = delete;

    bool wide;  // kernel with 8 lanes; otherwise 2

    // Spins with at most the energy of this speed; some are zero, denormal or have equal components.
    template <class Source>
    void add_spins(Draw<Source>& draw, double fast) {
        spin.assign(3 * s.n, 0.0);
        for (std::size_t i = 0; i < s.n; ++i) {
            inertia.push_back(draw.often({0.4, 0.5, 1.0}, [&] { return draw.between(0.05, 1.0); }));
            const double most = fast / (math::sqrt(inertia[i]) * radius[i]);
            for (std::size_t k = s.box.dimension == 2 ? 2 : 0; k < 3; ++k)
                spin[3 * i + k] =
                    most * draw.often({0.0, 1.0, -1.0, 1e-310}, [&] { return draw.between(-1.0, 1.0); });
        }
        s.angular_velocity = spin.data();
        s.inertia_factor = inertia.data();
    }

private:
    double together[3] = {}, apart = 1.0;
    bool mirrored, slow;

    // Makes a periodic axis the gradient. The speed of the images is at most `speed`, in the units of the velocities.
    template <class Source>
    void shear(Draw<Source>& draw) {
        const int axis = 1 + draw.below(s.box.dimension - 1);
        if (!s.box.is_periodic(0) || !s.box.is_periodic(axis)) return;
        s.box.boundary[axis] = boxes::Boundary::lees_edwards;
        s.box.edge[axis] = math::max(s.box.edge[axis], 5.0001 * large);
        s.box.gravity[0] = s.box.gravity[axis] = 0.0;
        const double images = draw.often({0.0, speed, -speed}, [&] { return draw.between(-speed, speed); });
        const double displaced = draw.often({0.0}, [&] { return draw.between(0.0, s.box.edge[0]); });
        s.box.shear(axis, images / s.box.edge[axis], displaced);
    }

    template <class Source>
    void add(Draw<Source>& draw, const int (&at)[3], double spacing, double size) {
        for (int k = 0; k < s.box.dimension; ++k) {
            const double room = 0.5 * spacing - size;
            const double aside = draw.often({0.0}, [&] { return draw.between(-room, room); });
            position.push_back(math::min(spacing * (at[k] + 0.5) + aside, s.box.edge[k]));
            double own = draw.often({0.0, speed, -speed}, [&] { return draw.between(-speed, speed); });
            if (mirrored) own = (at[0] + at[1] + at[2]) % 2 == 0 ? speed : -speed;
            if (slow) own *= draw.often({1.0, 0.0}, [&] { return draw.decades(1e-322, 1e-10); });
            velocity.push_back(together[k] + apart * own);
        }
        radius.push_back(size);
        mass.push_back(draw.often({1.0}, [&] { return draw.decades(1e-3, 1e3); }));
        ++s.n;
    }
};

}  // namespace hardlimit::fuzz
