// Defines the sequence of contacts of a column and its end, for all solvers.
//
// The floor contact begins a second time when the floor gap, having opened after the first floor contact, returns to 0.
// A floor force that vanishes and sets in again while the gap stays closed is not a second contact. t_f is the end of
// the last ball–ball contact that began before the second floor contact, even if it ends later. The separation velocity
// is the gap rate of the pair at the first instant >= t_f at which no force acts and the gap is not closing. For more
// than two balls the velocities are not defined. A single ball has only the floor contact; t_f is the last instant at
// which the floor force acts before the gap opens.
#pragma once
#include "../base/math.hpp"
#include "../base/outcome.hpp"

namespace hardlimit::column {

struct Sequence {
    int n_contacts = 0;  // ball–ball contacts
    double t_first_touch = math::nan;
    double t_second_touch = math::nan;  // start of the second floor contact
    double t_end = math::nan;
    double t_floor_end = math::nan;          // end of the first floor contact
    double relative_velocity = math::nan;    // paper's v'_r, at t_end
    double separation_velocity = math::nan;  // once no force acts
    Outcome outcome = Outcome::ok;

    bool one_ball = false;              // no pairs: the sequence is the floor contact
    bool floor_opened = false;          // the floor gap has opened after the first floor contact
    bool second_floor_contact = false;  // the second floor contact has begun
    bool finished = false;              // later contacts do not belong to the sequence
    int open_pairs = 0;                 // ball–ball contacts of the sequence that act now

    // The floor gap reaches zero from above, or the clipped floor force sets in again.
    HL_FN void floor_begins(double t) {
        if (math::is_nan(t_first_touch)) {
            t_first_touch = t;
        } else if (floor_opened) {
            if (!second_floor_contact) t_second_touch = t;
            second_floor_contact = true;
            if (open_pairs == 0) finished = true;
        } else if (one_ball) {
            t_end = math::nan;
        }
    }
    // Sets the origin of time to the first floor touch.
    HL_FN void clock_restarts() {
        t_end -= t_first_touch;
        t_first_touch = 0.0;
    }
    HL_FN void floor_ends(double t) {
        if (math::is_nan(t_floor_end)) t_floor_end = t;
        if (one_ball && !second_floor_contact) t_end = t;
    }
    // The floor gap reaches zero from below: the overlap ends, and with it the floor contact.
    HL_FN void floor_opens() { floor_opened = true; }

    // Returns whether the contact belongs to the sequence; if so, its end must be reported by pair_ends().
    HL_FN bool pair_begins() {
        if (second_floor_contact || finished) return false;
        ++n_contacts;
        ++open_pairs;
        relative_velocity = separation_velocity = t_end = math::nan;
        return true;
    }
    HL_FN void pair_ends(double t, double gap_rate) {
        --open_pairs;
        t_end = t;
        relative_velocity = gap_rate;
        separation_velocity = math::nan;
        if (second_floor_contact && open_pairs == 0) finished = true;
    }

    // No force acts on any ball. `gap_rate`: smallest rate of the ball–ball gaps. `floor_clear`: the lowest ball has
    // left the floor, or there is no floor.
    HL_FN void moves_freely(double gap_rate, bool floor_clear) {
        if (finished || gap_rate < 0.0) return;
        if (n_contacts > 0 && math::is_nan(separation_velocity)) separation_velocity = gap_rate;
        if (floor_clear) finished = true;
    }

    // A contact will never end. For a pair contact both velocities are zero by definition.
    HL_FN void comes_to_rest(bool pair_persists) {
        outcome = Outcome::at_rest;
        finished = true;
        if (pair_persists) {
            t_end = math::nan;
            relative_velocity = separation_velocity = 0.0;
        }
    }

    // At t a contact is compressed beyond the range of its law. The motion after t is unknown; if the sequence was not
    // over by then, its end and velocities are NaN.
    HL_FN void goes_too_deep(double t) {
        const bool over = finished && outcome != Outcome::at_rest && !(t_second_touch > t) && !(t_end > t);
        outcome = Outcome::too_deep;
        finished = true;
        if (t_second_touch > t) t_second_touch = math::nan;
        if (t_floor_end > t) t_floor_end = math::nan;
        if (!over) t_end = relative_velocity = separation_velocity = math::nan;
    }

    HL_FN void close() {
        if (outcome == Outcome::ok && n_contacts == 0 && !one_ball) outcome = Outcome::no_contact;
    }
};

}  // namespace hardlimit::column
