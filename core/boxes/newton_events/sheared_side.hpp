// The Lees–Edwards boundary. The images of bodies beyond it move along the first axis. Their cells slide past those of
// the box, so that a row of three cells has four neighbours there.
//
// A prediction moves the body to the frame of the images, and then reads their cells like any others. Each time the
// images have slid by the length of a cell, the bodies at both sides look into the next cell.
//
// A group lives in the frame of its first body. A member's image is the one nearest to it, and has the velocity of that
// image. The kinetic energy of a body in the laboratory differs from that in the frame of its group. The boundary does
// work when a body changes its frame, and while contacts across it act.
#pragma once
#include "engine.hpp"

namespace hardlimit::boxes {

// Number of whole cells by which the images beyond the far side are displaced.
template <class Law>
double NewtonEvents<Law>::displaced_cells() const {
    const double early = box_.image_velocity() < 0.0 ? -rounding_of_slides : rounding_of_slides;
    return math::floor_small(box_.image_displacement(now_) / grid().edge[0] + early);
}

// Time at which this number changes next.
template <class Law>
double NewtonEvents<Law>::next_slide() const {
    const double speed = box_.image_velocity(), cells = displaced_cells() + (speed > 0.0 ? 1.0 : 0.0);
    return speed == 0.0 ? math::infinity : (cells * grid().edge[0] - box_.shear_displacement) / speed;
}

// Calls f(block, image, beyond) for the part of a block in the box, and for its parts beyond the sheared side. The
// bodies in the cells of `block` are in the frame of `in` after `image` has been added to them.
template <class Law>
template <class F>
void NewtonEvents<Law>::for_sides(const Block& in, const F& f) const {
    if (!box_.is_sheared()) return f(in, ImageMotion{}, false);
    const int last = grid().cells[box_.gradient] - 1;
    for (const bool high : {false, true}) {
        if (high ? in.to[box_.gradient] <= last : in.from[box_.gradient] >= 0) continue;
        Block part = in;
        part.from[box_.gradient] = part.to[box_.gradient] = high ? 0 : last;
        f(part, slide_columns(part, high), true);
    }
    Block part = in;
    part.from[box_.gradient] = std::max(in.from[box_.gradient], 0);
    part.to[box_.gradient] = std::min(in.to[box_.gradient], last);
    if (part.from[box_.gradient] <= part.to[box_.gradient]) f(part, ImageMotion{}, false);
}

// Replaces the columns of a block by those of the images next to them, one more. Returns the motion of these images,
// which are shifted along the first axis by less than a period.
template <class Law>
ImageMotion NewtonEvents<Law>::slide_columns(Block& block, bool high) const {
    const int n = grid().cells[0];
    const double displaced = displaced_cells(), periods = math::floor_small(displaced / n);
    const auto columns = static_cast<int>(displaced - periods * n);
    block.from[0] += high ? -columns - 1 : columns;
    block.to[0] += high ? -columns : columns + 1;
    double flags[3] = {};
    flags[0] = high ? -periods : periods;
    flags[box_.gradient] = high ? 1.0 : -1.0;
    return box_.image(flags, now_);
}

// Whether the images slide past this cell.
template <class Law>
bool NewtonEvents<Law>::at_sheared_side(const Place<3>& at) const {
    return box_.is_sheared() &&
           (at[box_.gradient] == 0 || at[box_.gradient] == grid().cells[box_.gradient] - 1);
}

// Predicts collisions in the cells that the images have moved next to body i.
template <class Law>
void NewtonEvents<Law>::slide(int i) {
    const Place<3> at = cells_.place(level_, pending_[i].cell);
    set_query(i);
    for (const bool high : {false, true}) {
        if (at[box_.gradient] != (high ? grid().cells[box_.gradient] - 1 : 0)) continue;
        Block next = around(at);
        next.from[box_.gradient] = next.to[box_.gradient] = high ? at[box_.gradient] + 1 : -1;
        next.from[0] = next.to[0] = high == (box_.image_velocity() > 0.0) ? next.from[0] : next.to[0];
        predict_collisions(i, next);
    }
    predict_self_event(i, at);
    schedule(i);
}

// Moves body i, which has left through the sheared side, to its image in the box. Its neighbours in the box are those
// that it had, but it has others beyond the sides.
template <class Law>
void NewtonEvents<Law>::cross_sheared_side(int i, int step, Place<3>& at) {
    BodyEvents& e = pending_[i];
    Particle<3>& p = particles_[i];
    const double speed = velocity(i, now_)[0];
    int flags[3] = {};
    flags[box_.gradient] = step;
    const double x = position(i, now_)[0] - box_.image(flags, now_).shift[0];
    flags[0] = static_cast<int>(math::floor_small(x / box_.edge[0]));
    const ImageMotion image = box_.image(flags, p.time);
    for (std::size_t a = 0; a < 3; ++a) {
        p.position[a] -= image.shift[a];
        p.velocity[a] -= image.velocity[a];
        e.image_flags[a] += flags[a];
    }
    if (free(i)) shear_work_ += gained_energy(mass(i), speed, -image.velocity[0]);
    at[0] = static_cast<int>(math::clamp(position(i, now_)[0] / grid().edge[0], 0.0, grid().cells[0] - 1.0));
    e.cell = cells_.number(level_, at) & (most_cells - 1);
    cells_.insert(e.cell, static_cast<u32>(i));
    reschedule(i);
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
