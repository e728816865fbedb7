// The Lees–Edwards boundary. The images of bodies beyond it move along the first axis. A prediction moves the body to
// the frame of the images, and then reads their cells like any others.
//
// A group lives in the frame of its first body. A member's image is the one nearest to it, and has the velocity of that
// image. The kinetic energy of a body in the laboratory differs from that in the frame of its group. The boundary does
// work when a body changes its frame, and while contacts across it act.
#pragma once
#include "engine.hpp"

namespace hardlimit::boxes {

// Calls f(block, image) for a block, whose cells beyond a sheared side are left out, and for its parts there. The
// bodies in the cells of `block` are in the frame of `in` after `image` has been added to them.
template <class Law>
template <class F>
void NewtonEvents<Law>::for_sides(const Block& in, const F& f) const {
    f(in, ImageMotion{});
    if (!box_.is_sheared()) return;
    cells_.for_sheared_parts(box_, level_, in.from, in.to, now_,
                             [&](const Place<3>& from, const Place<3>& to, const ImageMotion& image) {
                                 f(Block{from, to}, image);
                             });
}

// Moves body i, which has left through the sheared side, to its image in the box.
template <class Law>
void NewtonEvents<Law>::cross_sheared_side(int i, int step) {
    Particle<3>& p = particles_[i];
    const double before = velocity(i, now_)[0], image_velocity = step * box_.image_velocity();
    if (free(i)) shear_work_ += gained_energy(mass(i), before, -image_velocity);
    box_.wrap(p.position, p.velocity, pending_[i].image_flags, box_.gradient, step, p.time);
}

// Puts a body into its column of cells, which are tilted in a sheared box.
template <class Law>
void NewtonEvents<Law>::fold_into_column(int i) {
    Particle<3>& p = particles_[i];
    Vector3 now = position(i, now_);
    const int turns = box_.turns(cells_.along(now.data(), now_), 0);
    if (turns != 0) box_.wrap(p.position, p.velocity, pending_[i].image_flags, 0, turns, p.time);
    double x[3] = {now[0] - turns * box_.edge[0], now[1], now[2]};
    pending_[i].cell = cells_.number(level_, cells_.place_of(level_, x, now_)) & (most_cells - 1);
}

// Tilts the columns of cells of a sheared box back, against the flow. All bodies get new cells, and all events are
// predicted again.
template <class Law>
void NewtonEvents<Law>::tilt_cells() {
    cells_.tilt_back();
    const int n = static_cast<int>(size32());
    for (int i = 0; i < n; ++i) fold_into_column(i);
    put_into_cells();
    for (int i = 0; i < n; ++i) predict_events(i);
    restart_calendar_queue();
}

// The image that must be subtracted from r to make it the shortest.
template <class Law>
typename NewtonEvents<Law>::BodyImage NewtonEvents<Law>::nearest_image(const Vector3& r) const {
    BodyImage nearest;
    for (int a = 1; a < 3; ++a) nearest.flags[a] = nearest_period(r[static_cast<std::size_t>(a)], a);
    const double across = r[static_cast<std::size_t>(box_.gradient)];
    nearest.flags[box_.gradient] = math::round_small(across / box_.edge[box_.gradient]);
    nearest.flags[0] = nearest_period(r[0] - box_.image(nearest.flags, now_).shift[0], 0);
    nearest.motion = box_.image(nearest.flags, now_);
    return nearest;
}

template <class Law>
void NewtonEvents<Law>::set_sheared_member(Group& g, std::size_t m, Member& member) const {
    const Particle<3>& p = particles_[g.body[m]];
    const std::array<int, 3>& flags = pending_[g.body[m]].image_flags;
    Vector3 r;
    for (std::size_t a = 0; a < 3; ++a) r[a] = p.position[a] - g.origin[a];
    const BodyImage image = nearest_image(r);
    for (std::size_t a = 0; a < 3; ++a) {
        member.position[a] = r[a] - image.motion.shift[a];
        member.velocity[a] = p.velocity[a] - image.motion.velocity[a];
        g.image_offset[m][a] = flags[a] + image.flags[a];
    }
}

template <class Law>
void NewtonEvents<Law>::set_sheared_image(const Member& a, const Member& b, ContactPair<Law>& q) const {
    Vector3 r;
    for (std::size_t k = 0; k < 3; ++k) r[k] = b.position[k] - a.position[k];
    const BodyImage image = nearest_image(r);
    for (std::size_t k = 0; k < 3; ++k) {
        q.image[k] = -image.motion.shift[k];
        q.image_velocity[k] = -image.motion.velocity[k];
    }
    q.image_moves = image.flags[box_.gradient] != 0.0;
}

// What a member's position, from the origin of its group, and its velocity lack in the frame of its body's cell.
template <class Law>
ImageMotion NewtonEvents<Law>::cell_frame(const Group& g, std::size_t m, double time) const {
    const std::array<int, 3>& image_flags = pending_[g.body[m]].image_flags;
    double flags[3];
    for (std::size_t a = 0; a < 3; ++a) flags[a] = g.image_offset[m][a] - image_flags[a];
    return box_.image(flags, time);
}

// Kinetic energy of the members in the frames of their cells, less that in the frame of the group [J].
template <class Law>
template <class Velocity>
double NewtonEvents<Law>::sheared_energy(const Group& g, const Velocity& velocity) const {
    double sum = 0.0;
    for (std::size_t m = 0; m < g.body.size(); ++m)
        sum += gained_energy(mass(g.body[m]), velocity(m)[0], cell_frame(g, m, now_).velocity[0]);
    return sum;
}

// Work of the boundary on a group since its begin, without pairs across it [J].
template <class Law>
template <class Velocity>
double NewtonEvents<Law>::shear_work(const Group& g, const Velocity& velocity) const {
    return !box_.is_sheared() ? 0.0 : sheared_energy(g, velocity) - g.sheared_energy;
}

// The same at the end of an isolated contact, where the members have their velocities.
template <class Law>
double NewtonEvents<Law>::shear_work_of_contact(const Group& g) const {
    return shear_work(g, [&](std::size_t m) {
        Vector3 v = velocity(g.body[m], now_);
        v[0] -= cell_frame(g, m, now_).velocity[0];
        return v;
    });
}

}  // namespace hardlimit::boxes
