// A macro for each of many arguments: GRIPLINE_FOR_EACH(f, S, a, b) is f(S, a) f(S, b), up to 80 arguments.
// By recursion through deferred expansion (D. Mazieres, "Recursive macros with C++20 __VA_OPT__", 2021).
#pragma once

#define GRIPLINE_PARENS ()
#define GRIPLINE_EXPAND(...) GRIPLINE_EXPAND3(GRIPLINE_EXPAND3(GRIPLINE_EXPAND3(__VA_ARGS__)))
#define GRIPLINE_EXPAND3(...) GRIPLINE_EXPAND2(GRIPLINE_EXPAND2(GRIPLINE_EXPAND2(__VA_ARGS__)))
#define GRIPLINE_EXPAND2(...) GRIPLINE_EXPAND1(GRIPLINE_EXPAND1(GRIPLINE_EXPAND1(__VA_ARGS__)))
#define GRIPLINE_EXPAND1(...) __VA_ARGS__
#define GRIPLINE_FOR_EACH(f, S, ...) __VA_OPT__(GRIPLINE_EXPAND(GRIPLINE_FOR_EACH_STEP(f, S, __VA_ARGS__)))
#define GRIPLINE_FOR_EACH_STEP(f, S, one, ...) \
  f(S, one) __VA_OPT__(GRIPLINE_FOR_EACH_AGAIN GRIPLINE_PARENS(f, S, __VA_ARGS__))
#define GRIPLINE_FOR_EACH_AGAIN() GRIPLINE_FOR_EACH_STEP
