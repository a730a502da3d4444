#include "car/integrator.hpp"

#include <array>

namespace gripline {
namespace {

constexpr double euler_b[] = {1.0};
constexpr double euler_c[] = {0.0};

constexpr double heun_a[] = {1.0};
constexpr double heun_b[] = {0.5, 0.5};
constexpr double heun_c[] = {0.0, 1.0};

constexpr double rk4_a[] = {0.5, 0.0, 0.5, 0.0, 0.0, 1.0};
constexpr double rk4_b[] = {1.0 / 6, 1.0 / 3, 1.0 / 3, 1.0 / 6};
constexpr double rk4_c[] = {0.0, 0.5, 0.5, 1.0};

constexpr double rkf5_a[] = {1.0 / 4,                   //
                             3.0 / 32,       9.0 / 32,  //
                             1932.0 / 2197,  -7200.0 / 2197,
                             7296.0 / 2197,  //
                             439.0 / 216,    -8.0,
                             3680.0 / 513,   -845.0 / 4104,  //
                             -8.0 / 27,      2.0,
                             -3544.0 / 2565, 1859.0 / 4104,
                             -11.0 / 40};
constexpr double rkf5_b[] = {16.0 / 135, 0.0, 6656.0 / 12825, 28561.0 / 56430, -9.0 / 50, 2.0 / 55};
constexpr double rkf5_c[] = {0.0, 1.0 / 4, 3.0 / 8, 12.0 / 13, 1.0, 1.0 / 2};

constexpr double rk6_a[] = {1.0 / 3,                                              //
                            0.0,       2.0 / 3,                                   //
                            1.0 / 12,  1.0 / 3,   -1.0 / 12,                      //
                            -1.0 / 16, 9.0 / 8,   -3.0 / 16, -3.0 / 8,            //
                            0.0,       9.0 / 8,   -3.0 / 8,  -3.0 / 4,  1.0 / 2,  //
                            9.0 / 44,  -9.0 / 11, 63.0 / 44, 18.0 / 11, 0.0,     -16.0 / 11};
constexpr double rk6_b[] = {11.0 / 120, 0.0, 27.0 / 40, 27.0 / 40, -4.0 / 15, -4.0 / 15, 11.0 / 120};
constexpr double rk6_c[] = {0.0, 1.0 / 3, 2.0 / 3, 1.0 / 3, 1.0 / 2, 1.0 / 2, 1.0};

constexpr std::array<Tableau, 5> all = {{
    {"euler", 1, 1, {}, euler_b, euler_c},
    {"heun", 2, 2, heun_a, heun_b, heun_c},
    {"rk4", 4, 4, rk4_a, rk4_b, rk4_c},
    {"rkf5", 5, 6, rkf5_a, rkf5_b, rkf5_c},
    {"rk6", 6, 7, rk6_a, rk6_b, rk6_c},
}};

}  // namespace

std::span<const Tableau> tableaux() { return all; }

const Tableau* find_tableau(std::string_view name) {
  for (const Tableau& one : all)
    if (one.name == name) return &one;
  return nullptr;
}

}  // namespace gripline
