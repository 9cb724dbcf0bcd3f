// The display over the picture: the server's state, the last break, hints and the crosshair.
#pragma once

#include "client/app/panel.hpp"

namespace fracture::app {

void draw_hud(const PanelState& state, const Snapshot& now, const protocol::Client& client);
void draw_help(const PanelState& state);
/// `aim`: where a ball would fly, in pixels of the window.
void draw_hint(const PanelState& state, const glm::vec2& aim);
/// Draws each fragment's number on it. The debug view of groups uses this.
void draw_fragment_ids(const game::Moment& moment, const render::Camera& camera, int width, int height);

}  // namespace fracture::app
