// Bullet's world with boxes that reach no farther than contacts do. Private to this folder.
#pragma once

#include <functional>

#include "client/world/bullet.hpp"

namespace fracture::world {

/// Bullet's own boxes reach two centimetres beyond each body, and five more in its tree, whatever the body's size: around a
/// shard of a few centimetres that is dozens of others to look at in every step. In a heap of 800 pieces a third of the
/// pairs go, of crates three fifths, and no contact.
class BoxedWorld final : public btDiscreteDynamicsWorld {
 public:
  BoxedWorld(btDispatcher* dispatcher, btBroadphaseInterface* boxes, btConstraintSolver* solver,
             btCollisionConfiguration* configuration);
  ~BoxedWorld() override;
  void updateAabbs() override;
  void calculateSimulationIslands() override;

  std::function<void()> when_contacts_are_found;  ///< before they are solved
};

}  // namespace fracture::world
