// Program for test_newton_events.py: compares the touch times of the kernels for random neighbours with distances at
// many times. During enlarged_span a neighbour touches the enlarged radius of the particle, later its radius. Prints
// the number of neighbours, of touches during and after that span, the largest relative error of a distance (overlap
// before the touch, or a gap at it), and the number of queries whose result depends on the number of lanes.
#include "boxes/kernels/touch_kernel.hpp"

#include <cmath>
#include <cstdio>
#include <cstring>
#include <random>
#include <vector>

using namespace hardlimit;
using namespace hardlimit::boxes;

template <Motion motion>
std::vector<double> times(const hardlimit_abi::ContactQuery& q, const std::vector<Particle<3>>& all,
                          int lanes, double& first) {
    std::vector<unsigned> ids;
    for (unsigned i = 0; i < all.size(); ++i) ids.push_back(i);
    ids.resize(all.size() + 16);
    std::vector<double> found(ids.size());
    const auto kernel = lanes == 2   ? touch_listed<Vector<2>::Real, 3, motion, Image::shifted, true>
                        : lanes == 4 ? touch_listed<Vector<4>::Real, 3, motion, Image::shifted, true>
                                     : touch_listed<Vector<8>::Real, 3, motion, Image::shifted, true>;
    first = kernel(q, all.data(), 0, ids.data(), found.data(), all.size()).time;
    found.resize(all.size());
    return found;
}

int main() {
    std::mt19937 engine(1);
    std::normal_distribution<double> normal(0.0, 1.0);
    std::uniform_real_distribution<double> uniform(0.0, 1.0);
    constexpr int queries = 4000, instants = 400;
    long asked = 0, in_space = 0, later = 0, unlike = 0;
    double wrong = 0.0;
    for (int i = 0; i < queries; ++i) {
        const bool falling = i % 2 != 0, shifted = i % 7 == 0;
        hardlimit_abi::ContactQuery q{};
        q.now = normal(engine);
        q.others = 1.0;
        q.radius = 0.5 + uniform(engine);
        q.enlarged_radius = i % 3 == 0 ? q.radius : q.radius * (1.0 + std::pow(10.0, -4.0 * uniform(engine)));
        q.enlarged_span = i % 3 == 0 ? 0.0 : std::pow(10.0, 1.0 - 4.0 * uniform(engine));
        for (int k = 0; k < 3; ++k) {
            q.position[k] = normal(engine), q.velocity[k] = normal(engine);
            q.shift[k] = shifted ? normal(engine) : 0.0;
            q.gravity[k] = falling ? normal(engine) : 0.0, q.half_gravity[k] = 0.5 * q.gravity[k];
        }
        // Neighbour 0 is the particle itself, unless images are shifted.
        std::vector<Particle<3>> all(1 + static_cast<std::size_t>(engine() % 30));
        for (std::size_t j = 0; j < all.size(); ++j) {
            Particle<3>& p = all[j];
            p.time = j == 0 || i % 5 == 0 ? q.now : q.now - uniform(engine);
            p.radius = 0.5 + uniform(engine);
            // Current position relative to the particle: far away, exactly at touch with either radius, or close to it.
            double r[3], v[3], length = 0.0;
            for (int k = 0; k < 3; ++k) r[k] = normal(engine), v[k] = normal(engine), length += r[k] * r[k];
            const double touch = p.radius + (engine() % 2 ? q.radius : q.enlarged_radius);
            const double part = std::pow(10.0, -6.0 * uniform(engine));
            const double distance = j % 4 == 0 ? touch : touch * (1.0 + (j % 4 == 1 ? 3.0 : part));
            const double s = q.now - p.time;
            for (int k = 0; k < 3; ++k) {
                r[k] *= j == 0 && !shifted ? 0.0 : distance / std::sqrt(length);
                v[k] *= j == 0 && !shifted ? 0.0 : 1.0;
                const double then = q.velocity[k] + v[k], x = q.position[k] + r[k] - q.shift[k];
                p.velocity[k] = then - q.gravity[k] * s;
                p.position[k] = x - s * (p.velocity[k] + q.half_gravity[k] * s);
            }
        }
        double first, least = INFINITY, same;
        const auto found =
            falling ? times<Motion::falling>(q, all, 8, first) : times<Motion::straight>(q, all, 8, first);
        for (const int lanes : {2, 4}) {
            const auto other = falling ? times<Motion::falling>(q, all, lanes, same)
                                       : times<Motion::straight>(q, all, lanes, same);
            unlike += std::memcmp(other.data(), found.data(), 8 * found.size()) != 0 || same != first;
        }
        for (std::size_t j = 0; j < all.size(); ++j) {
            const Particle<3>& p = all[j];
            const double s = q.now - p.time, space = q.enlarged_radius + p.radius,
                         touch = q.radius + p.radius;
            double r[3], v[3];
            for (int k = 0; k < 3; ++k) {
                r[k] =
                    p.position[k] + s * (p.velocity[k] + q.half_gravity[k] * s) + q.shift[k] - q.position[k];
                v[k] = p.velocity[k] + s * q.gravity[k] - q.velocity[k];
            }
            // Relative overlap of the pair at time t.
            const auto excess = [&](double t) {
                double square = 0.0;
                for (int k = 0; k < 3; ++k) square += (r[k] + t * v[k]) * (r[k] + t * v[k]);
                return 1.0 - std::sqrt(square) / (t <= q.enlarged_span ? space : touch);
            };
            const double time = found[j];
            least = std::fmin(least, time);
            if (j == 0 && !shifted) {
                if (time != INFINITY) wrong = INFINITY;
                continue;
            }
            ++asked;
            in_space += time <= q.enlarged_span && q.enlarged_span > 0.0;
            later += time > q.enlarged_span && time < INFINITY;
            if (time > 0.0 && time < INFINITY) wrong = std::fmax(wrong, std::fabs(excess(time)));
            if (time == 0.0) wrong = std::fmax(wrong, -excess(0.0));
            const double horizon = time < INFINITY ? time : 20.0;
            for (int m = 1; time > 0.0 && m < instants; ++m)
                wrong = std::fmax(wrong, excess(horizon * m / instants));
        }
        if (least != first) wrong = INFINITY;
    }
    std::printf("%ld %ld %ld %g %ld\n", asked, in_space, later, wrong, unlike);
}
