// What the studio puts into a document comes back, whatever somebody made of it.

#include "ui3d/studio/view/face.h"

#include <gtest/gtest.h>

namespace argil::studio {
namespace {

struct Desk {
  StudioState state;
  Camera camera;
};

Desk worked() {
  Desk d;
  render::View view;
  view.position = {30, -80, 45};
  view.target = {1, 2, 3};
  view.projection = render::Projection::orthographic;
  view.openingDegrees = 41;
  d.camera.set(view);
  d.state.look.section = d.state.section = render::Section{{0, 0, 5}, Vec3d(1, 1, 0).normalized()};
  d.state.look.shading = render::Shading::matcap;
  d.state.look.matcap = render::Matcap::steel;
  d.state.toolId = "smooth";
  d.state.tool().radiusMm = 7.25;
  return d;
}

TEST(Face, ComesBackAsItWas) {
  const Desk d = worked();
  Desk back;
  back.state.toolId = "add";
  ASSERT_TRUE(applyFace(faceText(d.state, d.camera), back.state, back.camera));
  EXPECT_EQ(back.camera.view().position, d.camera.view().position);
  EXPECT_EQ(back.camera.view().target, d.camera.view().target);
  EXPECT_LT((back.camera.view().up - d.camera.view().up).norm(), 1e-12);
  EXPECT_EQ(back.camera.view().projection, render::Projection::orthographic);
  EXPECT_EQ(back.camera.view().openingDegrees, 41);
  ASSERT_TRUE(back.state.look.section);
  EXPECT_EQ(back.state.look.section->pointMm, Vec3d(0, 0, 5));
  EXPECT_LT((back.state.look.section->normal - d.state.look.section->normal).norm(), 1e-12);
  EXPECT_EQ(back.state.look.shading, render::Shading::matcap);
  EXPECT_EQ(back.state.look.matcap, render::Matcap::steel);
  EXPECT_EQ(back.state.toolId, "smooth");
  EXPECT_EQ(back.state.tool().radiusMm, 7.25);
}

TEST(Face, ASectionThatIsOffStaysOffAndIsKept) {
  Desk d = worked(), back;
  d.state.look.section.reset();
  applyFace(faceText(d.state, d.camera), back.state, back.camera);
  EXPECT_FALSE(back.state.look.section);
  EXPECT_TRUE(back.state.section);
  // And that of the document before does not stay.
  Desk none;
  applyFace(faceText(none.state, none.camera), back.state, back.camera);
  EXPECT_FALSE(back.state.section);
}

TEST(Face, WhatIsWrongLeavesThingsAsTheyAre) {
  for (const char* text :
       {"", "[]", "nothing", "{}", R"({"view": 5, "section": [], "shading": 3, "matcap": "gold", "tool": "hammer"})",
        R"({"view": {"position": [0, 0, 0], "target": [0, 0, 0]}})",
        R"({"view": {"position": [0, 1], "target": ["a", 0, 0]}})",
        R"({"view": {"position": [0, 0, 1e300], "target": [0, 0, 0]}})",
        R"({"view": {"position": [0, 0, 9], "target": [0, 0, 0], "opening": 900}})",
        R"({"section": {"point": [0, 0, 0], "normal": [0, 0, 0]}, "tool": {"id": "hammer", "numbers": {"radius": 5}}})",
        R"({"tool": {"id": "carve", "numbers": {"radius": -3}}})", R"({"tool": {"id": "carve", "numbers": [1]}})"}) {
    Desk d;
    d.state.tool();
    const std::string before = faceText(d.state, d.camera);
    EXPECT_FALSE(applyFace(text, d.state, d.camera)) << text;
    EXPECT_EQ(faceText(d.state, d.camera), before) << text;
  }
  const std::string whole = faceText(worked().state, worked().camera);
  for (size_t length = 0; length < whole.size(); ++length) {
    Desk d;
    EXPECT_FALSE(applyFace(whole.substr(0, length), d.state, d.camera)) << length;
  }
}

}  // namespace
}  // namespace argil::studio
