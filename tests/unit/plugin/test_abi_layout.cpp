#include <gripline/abi_layout.hpp>

#include <gtest/gtest.h>

#include <cstdint>
#include <cstring>
#include <filesystem>
#include <string>
#include <vector>

#include "plugin/registry.hpp"
#include "support/host_support.hpp"

namespace gripline {
namespace test_abi_layout {

using namespace testing_support;

/// Places in a table of virtual functions, read from pointers to them (Itanium C++ ABI, 2.3: 1 plus an offset in
/// bytes).
void collect(const abi::detail::Chain<>&, std::vector<std::size_t>&) {}
template <class F, class... Rest>
void collect(const abi::detail::Chain<F, Rest...>& chain, std::vector<std::size_t>& places) {
  std::uintptr_t pointer = 0;
  std::memcpy(&pointer, &chain.first, sizeof pointer);
  places.push_back((pointer - 1) / sizeof(void*));
  collect(chain.rest, places);
}
template <class Interface>
std::vector<std::size_t> places() {
  std::vector<std::size_t> all;
  collect(abi::detail::Virtuals<Interface>::list, all);
  return all;
}

/// Behind the two destructors, or behind the functions of the first base, stand exactly those that are listed, in the
/// order in which they are declared; the last of the list is the one that a derived class would add.
template <class Interface, class Base = void>
void expect_complete(const char* name) {
  std::size_t first = 2;
  if constexpr (!std::is_void_v<Base>) first = places<Base>().back();
  for (const std::size_t place : places<Interface>())
    EXPECT_EQ(place, first++) << name << ": list its virtual functions in abi_layout.hpp in their order, all of them";
}

TEST(AbiLayout, EveryVirtualFunctionIsListed) {
  expect_complete<VehicleModel>("VehicleModel");
  expect_complete<Effect>("Effect");
  expect_complete<TyreCurve>("TyreCurve");
  expect_complete<Estimator, Effect>("Estimator");
  expect_complete<Prediction>("Prediction");
  expect_complete<Course>("Course");
  expect_complete<SpeedPlanner>("SpeedPlanner");
  expect_complete<Controller>("Controller");
  expect_complete<Truth>("Truth");
  expect_complete<Ground>("Ground");
  expect_complete<Plant>("Plant");
}

/// What crosses at the ABI number of these headers.
TEST(AbiLayout, NothingThatCrossesChangesWithoutANewNumber) {
  constexpr std::uint32_t number = 6;
  constexpr std::uint64_t hash = 0x7faeaa1bdec303ba;
  EXPECT_EQ(abi::number, number) << "write the new number and hash here";
  EXPECT_EQ(abi::layout_hash(), hash) << "what crosses changed: raise abi::number, then write both here";
}

std::string reason(const std::string& fixture) {
  if (!std::filesystem::exists(fixture_plugins(fixture) / (fixture + ".so"))) return "not built";
  const Registry registry({fixture_plugins(fixture)});
  return registry.unusable().size() == 1 ? registry.unusable()[0].reason : "usable";
}

TEST(AbiLayout, EveryKindOfEditIsNoticed) {
  EXPECT_EQ(reason("unedited"), "usable");
  for (const char* edit :
       {"members_swapped", "member_added", "member_of_another_type", "enumerator_moved", "virtual_of_another_type"})
    EXPECT_EQ(reason(edit),
              "its types (built by a compiler) differ from this gripline's; rebuild the plugin against the installed "
              "headers")
        << edit;
  for (const char* edit : {"virtuals_swapped", "virtual_added", "virtual_appended", "bases_swapped"})
    EXPECT_EQ(reason(edit),
              "its virtual functions (built by a compiler) stand in another order than this gripline's; rebuild the "
              "plugin against the installed headers")
        << edit;
}

}  // namespace test_abi_layout
}  // namespace gripline
