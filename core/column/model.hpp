// Table of the models of a column, used by Python, the command line, sweeps, plots and the web page.
#pragma once

namespace hardlimit::column {

// Model numbers, used in Python, result files and the web page, and as indices into model_records.
enum class Model : int { newton = 0, adiabatic = 1, independent = 2 };

struct ModelRecord {
    const char* name;          // for options and files
    const char* label;         // in a legend
    const char* short_label;   // at the head of a column of a table
    const char* abbreviation;  // in a plot with little room
    const char* limits;        // what it neglects, or where it fails
};

inline constexpr ModelRecord model_records[] = {
    {"newton", "Newton’s equations", "Newton", "Newton", "none beyond those of the contact law"},
    {"adiabatic", "adiabatic", "adiabatic", "adiabatic",
     "exact for R1 ≫ R2; the error falls as the mass ratio m2/m1"},
    {"independent", "independent collisions", "independent", "ICM",
     "right if every contact is over before the next one begins; may end in inelastic collapse"},
};

}  // namespace hardlimit::column
