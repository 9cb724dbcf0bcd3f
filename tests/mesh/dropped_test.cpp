#include "common/mesh/dropped.hpp"

#include <gtest/gtest.h>

namespace fracture {
namespace {

TEST(DroppedThings, AShortListStaysAsItIsWithoutRepetitions) {
  std::vector<Dropped> list = {{"light", "Lamp", "no lights"},
                               {"camera", "", "no cameras"},
                               {"light", "Lamp", "no lights"},
                               {"light", "Sun", "no lights"}};
  shorten_dropped(list);
  EXPECT_EQ(list, (std::vector<Dropped>{{"light", "Lamp", "no lights"},
                                        {"light", "Sun", "no lights"},
                                        {"camera", "", "no cameras"}}));
  EXPECT_EQ(to_text(list[0]), "light Lamp: no lights");
  EXPECT_EQ(to_text(list[2]), "camera: no cameras");
}

TEST(DroppedThings, FurtherOnesOfAKindAreCountedAndDoNotHideAnotherKind) {
  std::vector<Dropped> list;
  for (int k = 0; k < 1'500; ++k) list.push_back({"node", std::to_string(k), "empty"});
  list.push_back({"light", "Lamp", "no lights"});
  shorten_dropped(list);
  ASSERT_EQ(list.size(), kMostDropped + 2);
  EXPECT_EQ(list[19].name, "19");
  EXPECT_EQ(list[20].what, "node");
  EXPECT_EQ(to_text(list[20]), "node: 1,480 more are not listed");
  EXPECT_EQ(list[21].name, "Lamp");
  const std::vector<Dropped> once = list;
  shorten_dropped(list);
  EXPECT_EQ(list, once);
}

TEST(DroppedThings, ALongNameIsCutAtACharacter) {
  std::string name;
  for (int k = 0; k < 22; ++k) name += "\u6728";  // three bytes each
  std::vector<Dropped> list = {{"node", name, "empty"}, {"node", "x" + name, "empty"}};
  shorten_dropped(list);
  EXPECT_EQ(list[0].name, name.substr(0, 63));
  EXPECT_EQ(list[1].name, "x" + name.substr(0, 60)) << "62 bytes would divide a character";
}

}  // namespace
}  // namespace fracture
