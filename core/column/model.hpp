// The models of a column, by the numbers that Python, files of results and the page know them by.
#pragma once

namespace hardlimit::column {

enum class Model : int { newton = 0, adiabatic = 1, independent = 2 };

}  // namespace hardlimit::column
