// The frame of a group: positions from that of its first body, at the images of the others that are nearest to it.
//
// Beyond a Lees–Edwards boundary an image moves, and a member has the velocity of its image. The kinetic energy of a
// body in the laboratory differs from that in the frame of its group. The boundary does work when a body changes its
// frame, and while contacts across it act.
#pragma once
#include <algorithm>

#include "paths.hpp"

namespace hardlimit::boxes::events {

template <class Law>
class Frames {
public:
    using Group = ContactGroup<Law>;
    // Flags of an image, and what it adds to its particle.
    struct Image {
        double flags[3] = {};
        ImageMotion motion{};
    };

    explicit Frames(const Paths<Law>& paths) : paths_(paths) {
        for (int a = 0; a < 3; ++a) per_edge_[a] = box_.is_periodic(a) ? 1.0 / box_.edge[a] : 0.0;
    }

    // Opens the frame of a group whose bodies are known.
    void open(Group& g) const {
        g.image_offset.resize(g.body.size());
        std::copy_n(paths_.particles[g.body[0]].position, 3, g.origin.begin());
    }
    // Sets a member from the image of its body that is nearest to the group's origin, and stores which image that is.
    // Works element by element: wider loads just after narrow stores would stall (store forwarding).
    void set_member(Group& g, std::size_t m, Member& member) const {
        const int i = g.body[m];
        const Particle<3>& p = paths_.particles[i];
        member.mass = paths_.mass(i);
        member.radius = paths_.radius(i);
        Vector3 r;
        for (std::size_t a = 0; a < 3; ++a) r[a] = p.position[a] - g.origin[a];
        with_nearest_image(r, [&](const Image& image) {
            for (std::size_t a = 0; a < 3; ++a) {
                member.position[a] = r[a] - image.motion.shift[a];
                member.velocity[a] = p.velocity[a] - image.motion.velocity[a];
                g.image_offset[m][a] = paths_.pending[i].image_flags[a] + image.flags[a];
            }
        });
    }
    void set_pair(const Group& g, int i, int j, const Member& a, const Member& b, ContactPair<Law>& q) const {
        q = {};
        q.first = i;
        q.second = j;
        Vector3 r;
        for (std::size_t k = 0; k < 3; ++k) r[k] = b.position[k] - a.position[k];
        with_nearest_image(r, [&](const Image& image) {
            for (std::size_t k = 0; k < 3; ++k) q.image[k] = -image.motion.shift[k];
            q.image_velocity[0] = -image.motion.velocity[0];
            q.image_moves = box_.layer(image.flags) != 0;
        });
        q.contact_distance = a.radius + b.radius;
        q.mass = effective(a.mass, b.mass);
        paths_.laws().put(g.body[static_cast<std::size_t>(i)], g.body[static_cast<std::size_t>(j)], q.law);
    }
    ContactPair<Law> wall_pair(const Group& g, int i, const Wall& wall) const {
        const int body = g.body[static_cast<std::size_t>(i)];
        ContactPair<Law> q{};
        q.first = i;
        q.second = -1;
        q.wall_id = wall.id;
        q.axis = wall.id.axis();
        q.side = wall.inward();
        q.wall = wall.position(paths_.now) - g.origin[static_cast<std::size_t>(q.axis)];
        q.wall_velocity = wall.velocity(paths_.now);
        q.contact_distance = paths_.radius(body);
        q.mass = paths_.mass(body);
        q.law = paths_.laws()(body, -1);
        return q;
    }
    // The shortest vector between images, of this one.
    Vector3 nearest(Vector3 r) const {
        with_nearest_image(r, [&](const Image& image) {
            for (std::size_t k = 0; k < 3; ++k) r[k] -= image.motion.shift[k];
        });
        return r;
    }

    // What a member's position, from the origin of its group, and its velocity lack in the frame of its body's cell.
    ImageMotion cell_frame(const Group& g, std::size_t m, double time) const {
        const std::array<int, 3>& image_flags = paths_.pending[g.body[m]].image_flags;
        double flags[3];
        for (std::size_t a = 0; a < 3; ++a) flags[a] = g.image_offset[m][a] - image_flags[a];
        return box_.image(flags, time);
    }
    // Position of a member in the frame of its body's cell, and its velocity there at the current time.
    Vector3 body_position(const Group& g, std::size_t m, Vector3 x, double time) const {
        const ImageMotion image = cell_frame(g, m, time);
        for (std::size_t a = 0; a < 3; ++a) x[a] += g.origin[a] + image.shift[a];
        return x;
    }
    Vector3 body_velocity(const Group& g, std::size_t m, Vector3 v) const {
        v[0] -= cell_velocity(g, m);
        return v;
    }
    // Velocity of the frame of a body's cell in that of its group, along the first axis [m/s]; 0 without shear.
    double cell_velocity(const Group& g, std::size_t m) const {
        return box_.is_sheared() ? -cell_frame(g, m, paths_.now).velocity[0] : 0.0;
    }

    // Stores the energy from which shear_work() counts. velocity(m): of a member in the frame of the group.
    template <class Velocity>
    void begin_shear_work(Group& g, const Velocity& velocity) const {
        g.sheared_energy = sheared_energy(g, velocity);
    }
    // Work of the boundary on a group since its begin, without pairs across it [J].
    template <class Velocity>
    double shear_work(const Group& g, const Velocity& velocity) const {
        return sheared_energy(g, velocity) - g.sheared_energy;
    }
    // The same at the end of an isolated contact, where the members have their velocities.
    double shear_work_of_contact(const Group& g) const {
        return shear_work(g, [&](std::size_t m) {
            Vector3 v = paths_.velocity(g.body[m], paths_.now);
            v[0] += cell_velocity(g, m);
            return v;
        });
    }

private:
    const Paths<Law>& paths_;
    const Box& box_ = paths_.box;
    double per_edge_[3];  // 1/L along periodic axes, otherwise 0

    // Number of periods by which the nearest image of x is shifted.
    double nearest_period(double x, int axis) const { return math::round_small(x * per_edge_[axis]); }
    // Calls f(image) with the image that must be subtracted from r to make it the shortest.
    template <class F>
    void with_nearest_image(const Vector3& r, const F& f) const {
        if (box_.is_sheared()) return f(sheared_image(r));
        Image nearest;
        for (int a = 0; a < 3; ++a) {
            nearest.flags[a] = nearest_period(r[static_cast<std::size_t>(a)], a);
            nearest.motion.shift[a] = nearest.flags[a] * box_.edge[a];
        }
        f(nearest);
    }
    Image sheared_image(const Vector3& r) const {
        Image nearest;
        for (int a = 1; a < 3; ++a) nearest.flags[a] = nearest_period(r[static_cast<std::size_t>(a)], a);
        const double across = r[static_cast<std::size_t>(box_.gradient)];
        nearest.flags[box_.gradient] = math::round_small(across / box_.edge[box_.gradient]);
        nearest.flags[0] = nearest_period(r[0] - box_.image(nearest.flags, paths_.now).shift[0], 0);
        nearest.motion = box_.image(nearest.flags, paths_.now);
        return nearest;
    }
    // Kinetic energy of the members in the frames of their cells, less that in the frame of the group [J]; 0 without
    // shear.
    template <class Velocity>
    double sheared_energy(const Group& g, const Velocity& velocity) const {
        double sum = 0.0;
        if (!box_.is_sheared()) return sum;
        for (std::size_t m = 0; m < g.body.size(); ++m)
            sum += gained_energy(paths_.mass(g.body[m]), velocity(m)[0], -cell_velocity(g, m));
        return sum;
    }
};

}  // namespace hardlimit::boxes::events
