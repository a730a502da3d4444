// Four doubles at a time, and buffers aligned for them.
//
// Compiler vectors rather than intrinsics: the same source serves every processor, and what is not there is emulated.
// a * b + c stays two roundings (the build switches contraction off), so results do not depend on the instruction set.
#pragma once

#include <cstddef>
#include <vector>

// Without AVX these vectors travel between functions in another way than with it; none of them leaves a source file.
#pragma GCC diagnostic ignored "-Wpsabi"

namespace gripline::mpc_sqp {

using Vec4 [[gnu::vector_size(32), gnu::may_alias]] = double;

inline Vec4& vec4(double* aligned) { return *reinterpret_cast<Vec4*>(aligned); }
inline const Vec4& vec4(const double* aligned) { return *reinterpret_cast<const Vec4*>(aligned); }
inline Vec4 all(double value) { return Vec4{value, value, value, value}; }
inline Vec4 min(Vec4 a, Vec4 b) { return a < b ? a : b; }
inline Vec4 max(Vec4 a, Vec4 b) { return a > b ? a : b; }
inline double largest(Vec4 a) {
  const double low = a[0] > a[1] ? a[0] : a[1];
  const double high = a[2] > a[3] ? a[2] : a[3];
  return low > high ? low : high;
}
inline double sum(Vec4 a) { return (a[0] + a[1]) + (a[2] + a[3]); }
/// The four sums of four vectors.
inline Vec4 sums(Vec4 a, Vec4 b, Vec4 c, Vec4 d) {
  const Vec4 ab = __builtin_shufflevector(a, b, 0, 4, 2, 6) + __builtin_shufflevector(a, b, 1, 5, 3, 7);
  const Vec4 cd = __builtin_shufflevector(c, d, 0, 4, 2, 6) + __builtin_shufflevector(c, d, 1, 5, 3, 7);
  return __builtin_shufflevector(ab, cd, 0, 1, 4, 5) + __builtin_shufflevector(ab, cd, 2, 3, 6, 7);
}

/// n rounded up to whole vectors.
constexpr int padded(int n) { return (n + 3) / 4 * 4; }

/// Doubles on a 32-byte boundary, zero at first. Sized once; never grows.
class Buffer {
 public:
  Buffer() = default;
  explicit Buffer(std::size_t size) : blocks_((size + 3) / 4) {}
  double* data() { return reinterpret_cast<double*>(blocks_.data()); }
  const double* data() const { return reinterpret_cast<const double*>(blocks_.data()); }
  double& operator[](std::size_t i) { return data()[i]; }
  double operator[](std::size_t i) const { return data()[i]; }
  std::size_t size() const { return 4 * blocks_.size(); }

 private:
  struct alignas(32) Block {
    double v[4] = {};
  };
  std::vector<Block> blocks_;
};

}  // namespace gripline::mpc_sqp
