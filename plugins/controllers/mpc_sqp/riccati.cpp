#include "controllers/mpc_sqp/riccati.hpp"

#include <algorithm>
#include <cmath>

namespace gripline::ocp {

Links::Links(int horizon, int states)
    : horizon(horizon),
      states(states),
      n(padded(states)),
      width(4 + n),
      link_(offset_of(horizon, n * width)),
      offset_(offset_of(horizon, n)),
      hessian_u_(offset_of(horizon, 2 * width)),
      hessian_x_(offset_of(horizon + 1, n * n)),
      gradient_(offset_of(horizon + 1, width)),
      row_(offset_of(horizon + 1, n)) {}

void Links::set_dynamics(int k, const double* a, const double* b, int rows) {
  double* m = link(k);
  for (int i = 0; i < rows; ++i, m += width) {
    m[0] = b[2 * i];
    m[1] = b[2 * i + 1];
    std::copy_n(a + i * rows, rows, m + 4);
  }
}

namespace {

/// kStates is the padded number of states, or 0 where it is known at run time only.
template <int kStates>
class Recursion final : public Riccati {
 public:
  Recursion(int horizon, int states)
      : n_(padded(states)),
        cost_((horizon + 1) * size_n() * size_n()),
        linear_((horizon + 1) * size_n()),
        cost_offset_((horizon + 1) * size_n()),
        hux_((horizon + 1) * 2 * size_n()),
        gain_((horizon + 1) * 2 * size_n()),
        inverse_((horizon + 1) * 4),
        constant_((horizon + 1) * 4),
        next_(size_n()),
        product_(size_n() * (size_n() + 4)) {}

  bool factor(const Links& links, const RowTerms& rows) override;
  void solve(const Links& links, const RowTerms& rows, double* z, double* v) override;
  void curvatures(const Links& links, double* rows) const override;

 private:
  int n() const { return kStates > 0 ? kStates : n_; }
  std::size_t size_n() const { return static_cast<std::size_t>(n()); }
  double* at(Buffer& buffer, int k, int size) { return buffer.data() + static_cast<std::size_t>(k) * size; }
  const double* at(const Buffer& buffer, int k, int size) const {
    return buffer.data() + static_cast<std::size_t>(k) * size;
  }
  void transform(const double* p, const double* m);
  bool eliminate_inputs(const Links& links, const RowTerms& rows, int k);
  void cost_to_go(const Links& links, int k);
  void add_state_rows(const Links& links, const RowTerms& rows, int k);
  void backward(const Links& links, const RowTerms& rows);

  int n_;
  Buffer cost_, linear_;   // P_k [n][n] and p_k [n]: cost to go 1/2 x' P x + p' x
  Buffer cost_offset_;     // P_k+1 c_k [n]
  Buffer hux_;             // [2][n]
  Buffer gain_, inverse_;  // u = K x + constant: K [2][n]; inverse of the inputs' Hessian (00, 01, 11), 3 of 4
  Buffer constant_;        // [2], 2 of 4
  Buffer next_;            // gradient of the cost to go at c_k [n]
  Buffer product_;         // P_k+1 M_k [n][width]
};

/// product_ = P M, four rows at a time.
template <int kStates>
void Recursion<kStates>::transform(const double* p, const double* m) {
  const int n = this->n(), width = n + 4;
  double* out = product_.data();
  for (int i = 0; i < n; i += 4) {
    for (int j = 0; j < width; j += 4) {
      Vec4 s0{}, s1{}, s2{}, s3{};
      for (int l = 0; l < n; ++l) {
        const Vec4 b = vec4(m + l * width + j);
        const double* column = p + l * n + i;  // P is symmetric: its row l read as column l
        s0 += column[0] * b;
        s1 += column[1] * b;
        s2 += column[2] * b;
        s3 += column[3] * b;
      }
      vec4(out + (i + 0) * width + j) = s0;
      vec4(out + (i + 1) * width + j) = s1;
      vec4(out + (i + 2) * width + j) = s2;
      vec4(out + (i + 3) * width + j) = s3;
    }
  }
}

/// Hessian of the inputs, its inverse and the gain: Huu = Huu_k + B' P B + w, Hux = Hux_k + B' P A, K = -Huu^-1 Hux.
template <int kStates>
bool Recursion<kStates>::eliminate_inputs(const Links& links, const RowTerms& rows, int k) {
  const int n = this->n(), width = n + 4;
  const double* m = links.link(k);
  const double* hessian = links.hessian_u(k);
  Vec4 h0 = vec4(hessian), h1 = vec4(hessian + width);
  for (int l = 0; l < n; ++l) {
    const Vec4 w = vec4(product_.data() + l * width);
    h0 += m[l * width] * w;
    h1 += m[l * width + 1] * w;
  }
  const double* weight = rows.weight.data() + row_count * k;
  const double a = h0[0] + weight[row_input0], b = h0[1], c = h1[1] + weight[row_input1];
  const double ratio = b / a, schur = c - b * ratio;
  if (!(a > 0) || !(schur > 1e-14 * c) || !std::isfinite(a + c)) return false;
  double* inverse = at(inverse_, k, 4);
  inverse[2] = 1.0 / schur;
  inverse[1] = -ratio * inverse[2];
  inverse[0] = 1.0 / a - ratio * inverse[1];
  double* hux = at(hux_, k, 2 * n);
  double* gain = at(gain_, k, 2 * n);
  for (int j = 0; j < n; j += 4) {
    Vec4 x0 = vec4(hessian + 4 + j), x1 = vec4(hessian + width + 4 + j);
    for (int l = 0; l < n; ++l) {
      const Vec4 w = vec4(product_.data() + l * width + 4 + j);
      x0 += m[l * width] * w;
      x1 += m[l * width + 1] * w;
    }
    vec4(hux + j) = x0;
    vec4(hux + n + j) = x1;
    vec4(gain + j) = -(inverse[0] * x0 + inverse[1] * x1);
    vec4(gain + n + j) = -(inverse[1] * x0 + inverse[2] * x1);
  }
  return true;
}

/// P_k = Hxx + A' P A + Hux' K: the blocks on and right of the diagonal, the others mirrored.
template <int kStates>
void Recursion<kStates>::cost_to_go(const Links& links, int k) {
  const int n = this->n(), width = n + 4;
  const double* m = links.link(k);
  const double* hessian = links.hessian_x(k);
  const double* hux = at(hux_, k, 2 * n);
  const double* gain = at(gain_, k, 2 * n);
  double* p = at(cost_, k, n * n);
  for (int i = 0; i < n; i += 4) {
    for (int j = i; j < n; j += 4) {
      Vec4 s[4];
      const Vec4 k0 = vec4(gain + j), k1 = vec4(gain + n + j);
      for (int r = 0; r < 4; ++r) {
        s[r] = vec4(hessian + (i + r) * n + j) + hux[i + r] * k0 + hux[n + i + r] * k1;
      }
      for (int l = 0; l < n; ++l) {
        const Vec4 w = vec4(product_.data() + l * width + 4 + j);
        const double* column = m + l * width + 4 + i;
        s[0] += column[0] * w;
        s[1] += column[1] * w;
        s[2] += column[2] * w;
        s[3] += column[3] * w;
      }
      for (int r = 0; r < 4; ++r) vec4(p + (i + r) * n + j) = s[r];
      if (j == i) {
        for (int r = 1; r < 4; ++r) {
          for (int q = 0; q < r; ++q) p[(i + r) * n + i + q] = p[(i + q) * n + i + r];
        }
      } else {
        for (int r = 0; r < 4; ++r) {
          for (int q = 0; q < 4; ++q) p[(j + q) * n + i + r] = s[r][q];
        }
      }
    }
  }
}

template <int kStates>
void Recursion<kStates>::add_state_rows(const Links& links, const RowTerms& rows, int k) {
  const int n = this->n();
  double* p = at(cost_, k, n * n);
  const double* weight = rows.weight.data() + row_count * k;
  const int bounded = links.bounded_state;
  const double* row = links.row(k);
  p[bounded * n + bounded] += weight[row_state];
  if (weight[row_soft] == 0) return;
  for (int i = 0; i < n; ++i) {
    const double scale = weight[row_soft] * row[i];
    if (scale == 0) continue;
    for (int j = 0; j < n; j += 4) vec4(p + i * n + j) += scale * vec4(row + j);
  }
}

template <int kStates>
bool Recursion<kStates>::factor(const Links& links, const RowTerms& rows) {
  const int n = this->n();
  const int last = links.horizon;
  std::copy_n(links.hessian_x(last), n * n, at(cost_, last, n * n));
  add_state_rows(links, rows, last);
  for (int k = last - 1; k >= 0; --k) {
    const double* p = at(cost_, k + 1, n * n);
    const double* c = links.offset(k);
    double* pc = at(cost_offset_, k, n);
    for (int j = 0; j < n; j += 4) {
      Vec4 s{};
      for (int l = 0; l < n; ++l) s += c[l] * vec4(p + l * n + j);
      vec4(pc + j) = s;
    }
    transform(p, links.link(k));
    if (!eliminate_inputs(links, rows, k)) return false;
    if (k == 0) break;  // x_0 is given
    cost_to_go(links, k);
    add_state_rows(links, rows, k);
  }
  return true;
}

/// p_k = g + rows + A' (P_k+1 c_k + p_k+1) + K' h_u and the constant part of the inputs, -Huu^-1 h_u.
template <int kStates>
void Recursion<kStates>::backward(const Links& links, const RowTerms& rows) {
  const int n = this->n(), width = n + 4;
  double* next = next_.data();
  std::copy_n(links.gradient(links.horizon) + 4, n, at(linear_, links.horizon, n));
  for (int k = links.horizon;; --k) {
    double* p = at(linear_, k, n);
    const double* shift = rows.shift.data() + 4 * k;
    const double* row = links.row(k);
    p[links.bounded_state] += shift[row_state];
    for (int j = 0; j < n; j += 4) vec4(p + j) += shift[row_soft] * vec4(row + j);
    if (k == 0) break;

    const double* m = links.link(k - 1);
    const double* g = links.gradient(k - 1);
    const double* pc = at(cost_offset_, k - 1, n);
    const double* input_shift = rows.shift.data() + 4 * (k - 1);
    for (int j = 0; j < n; j += 4) vec4(next + j) = vec4(p + j) + vec4(pc + j);
    Vec4 hu = vec4(g);
    for (int l = 0; l < n; ++l) hu += next[l] * vec4(m + l * width);
    const double h0 = hu[0] + input_shift[row_input0], h1 = hu[1] + input_shift[row_input1];
    const double* inverse = at(inverse_, k - 1, 4);
    double* constant = at(constant_, k - 1, 4);
    constant[0] = -(inverse[0] * h0 + inverse[1] * h1);
    constant[1] = -(inverse[1] * h0 + inverse[2] * h1);
    const double* gain = at(gain_, k - 1, 2 * n);
    double* before = at(linear_, k - 1, n);
    for (int j = 0; j < n; j += 4) {
      Vec4 s = vec4(g + 4 + j) + h0 * vec4(gain + j) + h1 * vec4(gain + n + j);
      for (int l = 0; l < n; ++l) s += next[l] * vec4(m + l * width + 4 + j);
      vec4(before + j) = s;
    }
  }
}

template <int kStates>
void Recursion<kStates>::solve(const Links& links, const RowTerms& rows, double* z, double* v) {
  backward(links, rows);
  const int n = this->n(), width = n + 4;
  for (int k = 0;; ++k, z += width, v += 4) {
    const double* x = z + 4;
    const double* row = links.row(k);
    Vec4 along{};
    for (int j = 0; j < n; j += 4) along += vec4(row + j) * vec4(x + j);
    Vec4 u{};
    if (k < links.horizon) {
      const double* gain = at(gain_, k, 2 * n);
      const double* constant = at(constant_, k, 4);
      Vec4 u0{}, u1{};
      for (int j = 0; j < n; j += 4) {
        u0 += vec4(gain + j) * vec4(x + j);
        u1 += vec4(gain + n + j) * vec4(x + j);
      }
      u = Vec4{constant[0] + sum(u0), constant[1] + sum(u1), 0, 0};
    }
    vec4(z) = u;
    vec4(v) = Vec4{u[0], u[1], x[links.bounded_state], sum(along)};
    if (k == links.horizon) return;
    const double* m = links.link(k);
    const double* c = links.offset(k);
    double* after = z + width + 4;
    for (int i = 0; i < n; i += 4, m += 4 * width) {
      Vec4 s[4] = {};
      for (int j = 0; j < width; j += 4) {
        const Vec4 zj = vec4(z + j);
        for (int r = 0; r < 4; ++r) s[r] += vec4(m + r * width + j) * zj;
      }
      vec4(after + i) = vec4(c + i) + sums(s[0], s[1], s[2], s[3]);
    }
  }
}

template <int kStates>
void Recursion<kStates>::curvatures(const Links& links, double* rows) const {
  const int n = this->n();
  for (int k = 0; k <= links.horizon; ++k, rows += row_count) {
    std::fill_n(rows, row_count, 0.0);
    if (k < links.horizon) {
      const double* inverse = at(inverse_, k, 4);
      const double determinant = inverse[0] * inverse[2] - inverse[1] * inverse[1];
      rows[row_input0] = inverse[2] / determinant;
      rows[row_input1] = inverse[0] / determinant;
    }
    if (k == 0) continue;
    const double* p = at(cost_, k, n * n);
    const double* row = links.row(k);
    rows[row_state] = p[links.bounded_state * n + links.bounded_state];
    for (int i = 0; i < n; ++i) {
      for (int j = 0; row[i] != 0 && j < n; ++j) rows[row_soft] += row[i] * p[i * n + j] * row[j];
    }
  }
}

}  // namespace

std::unique_ptr<Riccati> make_riccati(int horizon, int states) {
  switch (padded(states)) {
    case 4:
      return std::make_unique<Recursion<4>>(horizon, states);
    case 8:
      return std::make_unique<Recursion<8>>(horizon, states);
    case 12:
      return std::make_unique<Recursion<12>>(horizon, states);
    case 16:
      return std::make_unique<Recursion<16>>(horizon, states);
    default:
      return std::make_unique<Recursion<0>>(horizon, states);
  }
}

}  // namespace gripline::ocp
