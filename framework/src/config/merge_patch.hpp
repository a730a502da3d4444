#pragma once
#include <string_view>

#include "config/node.hpp"

namespace gripline {

/// RFC 7396: members of `patch` replace those of `base`, objects are merged, null removes, anything else replaces.
/// Every value keeps the origin of the file it came from; an object built from both keeps the base's, unless the patch
/// removes one of its members or the base stands in no file: then whatever is missing is missing because of the patch.
[[nodiscard]] Node merge(Node base, const Node& patch);

/// merge(), but nulls of the patch are kept, in the place of the member they remove or as new members: what "extends"
/// uses (see load_json), since the result may be a patch itself, such as a stack that is merged over "base" later.
/// Readers take null for absent; a null in a member's place has it as `replaced`.
[[nodiscard]] Node merge_keeping_nulls(Node base, const Node& patch);

/// Takes the nulls that stand in the place of a member out of a tree that is not a patch, at any depth.
void drop_removed(Node& node);

/// Carries out `--set /json/pointer=VALUE`. VALUE is read as JSON if it is JSON, else taken as text (`20 ms`).
/// Names that are missing on the way are made objects; a parent that is something else is refused (InputError), also a
/// null: an object in its place would bring back what it removes where the tree is a patch, such as a stack. In an
/// array a name is an index, or `-` for one more element at the end.
/// Relative paths in VALUE start at the working folder.
void apply_assignment(Node& root, std::string_view assignment);

/// apply_assignment() with pointer and value given apart. Throws InputError.
void set_pointer(Node& root, std::string_view pointer, std::string_view value);

}  // namespace gripline
