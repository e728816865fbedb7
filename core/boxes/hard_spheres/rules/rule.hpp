// Interface of the collision rules. A rule gives the restitution of a collision or its equivalent collision.
//
// A rule is a class that derives from Rule, with
//   record                    name, parameters and meaning, which the bindings and the documentation read
//   make(choice, typical)     the rule as the user chose it
// in a header of its own, and one line in registry.hpp.
#pragma once
#include <memory>

#include "../../binary_contact/deepest_impact.hpp"
#include "../../binary_contact/equivalent_collision.hpp"
#include "../../binary_contact/turning_contact.hpp"
#include "../../common/law_choice.hpp"

namespace hardlimit::boxes {

struct RuleParameter {
    const char* name;
    const char* unit;
    const char* meaning;
};
inline constexpr int max_rule_parameters = 2, max_rule_counts = 3;

struct RuleRecord {
    const char* name;
    const char* meaning;  // what a collision does
    const char* assumes;  // what must hold for the rule to be right
    const char* source = "";
    bool takes_restitution = false, takes_law = false;  // both: either of the two
    // Whether the rule knows the duration of contacts: a collapse is then not an artefact of instantaneous collisions.
    bool knows_duration = false;
    // Rule of the law of the error (error_law.hpp) with the same error: "constant", "tc" or "soft"; empty if not known.
    const char* error = "";
    int n_counts = 0;
    const char* counts[max_rule_counts] =
        {};                  // attributes of a result; the last is a share of the collisions
    const char* share = "";  // what this share means
    int n_parameters = 0;
    RuleParameter parameters[max_rule_parameters] = {};
};

// A rule and its parameters, as chosen in Python and stored in checkpoints.
struct RuleChoice {
    int rule = 0;              // index in the registry of rules
    double restitution = 1.0;  // without a law
    LawChoice law;
    double parameters[max_rule_parameters] = {};  // in the order of the record
    // Of the constant rule, without a law: coefficient of friction μ, 0: none; and β without sliding.
    double friction = 0.0, tangential_restitution = -1.0;

    bool has_friction() const { return particles_rub && (friction > 0.0 || law.has_friction()); }
};

// Kinds of particles with friction, which differ in mass, radius or inertia factor: so few that each pair of kinds may
// have tables; many with the same inertia factor; many.
enum class Kinds : unsigned char { few, many_of_one_shape, many };

// The largest particle, for which rules make tables. `alike`: all particles are of this kind.
struct TypicalParticle {
    double mass, radius;  // [kg], [m]
    bool alike;
    Kinds kinds = Kinds::few;

    PairGeometry pair() const { return {0.5 * mass, 0.5 * radius}; }
    PairGeometry at_wall() const { return {mass, radius}; }
};

// Two particles, or a particle and a wall, at touch.
struct Impact {
    Approach approach;
    PairGeometry pair;
    double smaller_radius;  // [m]
    double since_last;  // time since the last collision of either, the shorter [s]; infinite before the first
    // With friction.
    double slip_speed = 0.0;        // tangential speed of the surfaces [m/s]
    double rotational_ratio = 0.0;  // m (R_i²/I_i + R_j²/I_j) with the effective mass m; m/m_t − 1
    u64 collisions = 0;             // of the run, before this one
};

// Result of an instantaneous collision.
struct Rebound {
    double restitution;
    bool elastic_by_tc = false;    // made elastic by the rule tc
    double tangential_gain = 0.0;  // 1 + β; NaN if the contact was not solved
    bool slid = false;             // the surfaces have slipped; without a law: |J_t| = μ J_n
};

// Result of a contact of finite duration.
struct SoftContact {
    Outcome outcome = Outcome::ok;
    EquivalentCollision collision{};
    double duration = 0.0;  // [s]
};

class Rule {
public:
    virtual ~Rule() = default;

    // Whether contacts take time and displace the particles: then the engine calls contact(), otherwise rebound(). Both
    // record the deepest impact of a law. If it is too deep, the run ends and their result is not used.
    virtual bool takes_time() const { return false; }
    virtual Rebound rebound(const Impact&, DeepestImpact&) { return {1.0}; }
    virtual SoftContact contact(const Impact&, DeepestImpact&) { return {}; }
    // The contact of surfaces with friction, if contacts take time. At a wall contact() gives the normal motion.
    virtual TurningContact turning_contact(const TurningApproach&, const Impact&, DeepestImpact&) {
        return {};
    }
    // Whether infinitely many collisions are possible in a finite time.
    virtual bool can_collapse() const { return true; }
};

// Defined in registry.hpp.
std::unique_ptr<Rule> make_rule(const RuleChoice& choice, const TypicalParticle& typical);

}  // namespace hardlimit::boxes
