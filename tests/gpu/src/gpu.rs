//! The least of a host: an adapter, the shader with some entry points of ours behind it, buffers in, words out.

use std::fmt;

use wgpu::util::{BufferInitDescriptor, DeviceExt};
use wgpu::{BindingResource, Buffer, BufferUsages, ComputePipeline};

/// An adapter and the shader on it.
pub struct Gpu {
    pub name: String,
    device: wgpu::Device,
    queue: wgpu::Queue,
    module: wgpu::ShaderModule,
    /// The software adapter of Mesa.
    pub is_llvmpipe: bool,
}

/// A scene in the adapter's memory.
pub struct Scene {
    words: Buffer,
    uniform: Buffer,
}

/// Why there is nothing to run on.
pub struct NoAdapter(String);

impl fmt::Display for NoAdapter {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(&self.0)
    }
}

impl Gpu {
    /// The fastest adapter, a real one if there is one, with `source` as its shader. `WGPU_ADAPTER_NAME` chooses another.
    pub fn new(source: &str) -> Result<Gpu, NoAdapter> {
        let instance = wgpu::Instance::new(wgpu::InstanceDescriptor::new_without_display_handle());
        let named = std::env::var("WGPU_ADAPTER_NAME").ok();
        let mut adapters = pollster::block_on(instance.enumerate_adapters(wgpu::Backends::PRIMARY));
        adapters.retain(|a| named.as_ref().is_none_or(|name| a.get_info().name.contains(name)));
        let rank = |a: &wgpu::Adapter| match a.get_info().device_type {
            wgpu::DeviceType::DiscreteGpu => 0,
            wgpu::DeviceType::IntegratedGpu | wgpu::DeviceType::VirtualGpu => 1,
            _ => 2,
        };
        let adapter = adapters.into_iter().min_by_key(rank).ok_or(NoAdapter("there is none".into()))?;
        let info = adapter.get_info();
        // Scenes beyond the 128 MiB that every adapter takes need what this one has.
        let limits = adapter.limits();
        let (device, queue) = pollster::block_on(adapter.request_device(&wgpu::DeviceDescriptor {
            required_limits: wgpu::Limits {
                max_storage_buffer_binding_size: limits.max_storage_buffer_binding_size,
                max_buffer_size: limits.max_buffer_size,
                ..wgpu::Limits::downlevel_defaults()
            },
            ..Default::default()
        }))
        .map_err(|e| NoAdapter(format!("{}: {e}", info.name)))?;
        let module = device.create_shader_module(wgpu::ShaderModuleDescriptor {
            label: None,
            source: wgpu::ShaderSource::Wgsl(source.into()),
        });
        let name = format!("{} ({:?}, {} {})", info.name, info.device_type, info.driver, info.driver_info);
        Ok(Gpu { name, device, queue, module, is_llvmpipe: info.driver == "llvmpipe" })
    }

    /// Uploads a scene's words as they are, and its uniform.
    pub fn scene(&self, words: &[u32], uniform: &[u32]) -> Scene {
        Scene { words: self.buffer(words, BufferUsages::STORAGE), uniform: self.buffer(uniform, BufferUsages::UNIFORM) }
    }

    /// An entry point of the shader.
    pub fn pipeline(&self, entry: &str) -> ComputePipeline {
        self.device.create_compute_pipeline(&wgpu::ComputePipelineDescriptor {
            label: Some(entry),
            layout: None,
            module: &self.module,
            entry_point: Some(entry),
            compilation_options: Default::default(),
            cache: None,
        })
    }

    /// Runs an entry point over `groups` workgroups with `input` at group 1, binding 0, and gives the `count` words that it
    /// wrote to binding 1.
    pub fn run(
        &self,
        pipeline: &ComputePipeline,
        scene: &Scene,
        (input, usage): (&[u32], BufferUsages),
        groups: [u32; 2],
        count: usize,
    ) -> Vec<u32> {
        let input = self.buffer(input, usage);
        let size = 4 * count as u64;
        let make = |usage| {
            self.device.create_buffer(&wgpu::BufferDescriptor { label: None, size, usage, mapped_at_creation: false })
        };
        let output = make(BufferUsages::STORAGE | BufferUsages::COPY_SRC);
        let back = make(BufferUsages::MAP_READ | BufferUsages::COPY_DST);
        let bind = |group: u32, buffers: [&Buffer; 2]| {
            let entries = [0, 1].map(|i| wgpu::BindGroupEntry {
                binding: i as u32,
                resource: BindingResource::Buffer(buffers[i].as_entire_buffer_binding()),
            });
            let layout = &pipeline.get_bind_group_layout(group);
            self.device.create_bind_group(&wgpu::BindGroupDescriptor { label: None, layout, entries: &entries })
        };
        let groups_bound = [bind(0, [&scene.words, &scene.uniform]), bind(1, [&input, &output])];

        let mut encoder = self.device.create_command_encoder(&Default::default());
        {
            let mut pass = encoder.begin_compute_pass(&Default::default());
            pass.set_pipeline(pipeline);
            for (i, group) in groups_bound.iter().enumerate() {
                pass.set_bind_group(i as u32, group, &[]);
            }
            pass.dispatch_workgroups(groups[0], groups[1], 1);
        }
        encoder.copy_buffer_to_buffer(&output, 0, &back, 0, size);
        self.queue.submit([encoder.finish()]);

        back.map_async(wgpu::MapMode::Read, .., |result| result.expect("the buffer can be mapped"));
        self.device.poll(wgpu::PollType::wait_indefinitely()).expect("the adapter answers");
        let bytes = back.get_mapped_range(..).expect("the buffer is mapped");
        bytes.as_chunks::<4>().0.iter().map(|bytes| u32::from_le_bytes(*bytes)).collect()
    }

    fn buffer(&self, words: &[u32], usage: BufferUsages) -> Buffer {
        let bytes: Vec<u8> = words.iter().flat_map(|word| word.to_le_bytes()).collect();
        self.device.create_buffer_init(&BufferInitDescriptor { label: None, contents: &bytes, usage })
    }
}
