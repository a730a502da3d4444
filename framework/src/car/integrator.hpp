// Explicit Runge-Kutta methods by their Butcher tableaux.
#pragma once

#include <span>
#include <string_view>

namespace gripline {

/// y += h sum b_i k_i, k_i = f(t + c_i h, y + h sum_j a_ij k_j). `a` holds the strictly lower rows one after another.
struct Tableau {
  std::string_view name;
  int order;
  int stages;
  std::span<const double> a, b, c;
  double weight(int row, int column) const {
    return a[static_cast<std::size_t>(row) * (static_cast<std::size_t>(row) - 1) / 2 +
             static_cast<std::size_t>(column)];
  }
};

/// "euler", "heun", "rk4"; "rkf5": the fifth-order weights of Fehlberg (NASA TR R-315, 1969, table III), which the
/// published runs call RK6; "rk6": Butcher's sixth-order method of seven stages (J. Austral. Math. Soc. 4, 1964).
std::span<const Tableau> tableaux();
/// Null when there is none of that name.
const Tableau* find_tableau(std::string_view name);

}  // namespace gripline
