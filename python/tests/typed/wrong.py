"""A program in which strict type checkers find each line that is marked."""

import numpy as np

import gpu_stereo

image = np.zeros((8, 40), np.uint8)
gpu_stereo.match(image, image, "many")  # wrong
gpu_stereo.match(image, image, 64, cost="zncc")  # wrong
gpu_stereo.match(image, image, 64, nonsense=1)  # wrong
gpu_stereo.match([1], image)  # wrong
gpu_stereo.match(image, image).shape.x  # wrong
gpu_stereo.StereoMatcher(741)  # wrong
text: str = gpu_stereo.match(image, image).raw  # wrong
